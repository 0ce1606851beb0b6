"""Whole numbers survive as text."""

from __future__ import annotations

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.scoring.poses.vlq import decode, encode


def test_numbers_of_every_size_and_sign_survive() -> None:
    numbers = [0, 1, -1, 15, -15, 16, -16, 511, 512, -123_456_789, 2**40]
    assert decode(encode(numbers)) == numbers


def test_the_text_is_that_of_source_maps() -> None:
    assert encode([0, 1, -1, 16, -16, 123]) == "ACDgBhB2H"


def test_a_small_number_takes_one_character() -> None:
    assert all(len(encode([number])) == 1 for number in range(-15, 16))


def test_a_strange_character_is_refused() -> None:
    with pytest.raises(BenchError, match="Unexpected character '<' in a motion"):
        decode("AC<")


def test_an_incomplete_number_is_refused() -> None:
    with pytest.raises(BenchError, match="The last number of a motion is incomplete"):
        decode("Ag")
