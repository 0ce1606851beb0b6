"""Numbers have fixed digits, a minus sign and no negative zero."""

from __future__ import annotations

import pytest

from gym_extensions.site.text import numbers


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (0.0, 2, "0.00"),
        (-0.0, 2, "0.00"),
        (-0.004, 2, "0.00"),
        (-0.006, 2, "−0.01"),
        (-153.94, 1, "−153.9"),
        (2690.57, 0, "2691"),
        (0.125, 2, "0.12"),
        (-1.5, 2, "−1.50"),
    ],
)
def test_a_number_has_fixed_digits_and_a_minus_sign(value: float, digits: int, text: str) -> None:
    assert numbers.fixed(value, digits) == text


def test_the_ends_of_an_interval_are_joined_by_a_word() -> None:
    assert numbers.interval(-0.031, 0.412) == "−0.03 to 0.41"


@pytest.mark.parametrize(
    ("values", "digits"), [([], 2), ([0.3, -1.2], 2), ([9.0, -10.0], 1), ([999.0], 1), ([-1000.0, 2.0], 0)]
)
def test_larger_values_have_fewer_decimals(values: list[float], digits: int) -> None:
    assert numbers.digits_for(values) == digits


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "yes"),
        (False, "no"),
        (50000, "50\u202f000"),
        (1e-05, "1e−05"),
        ([100, 50, 25], "100, 50, 25"),
        ("Linux-x86_64", "Linux-x86_64"),
    ],
)
def test_a_manifest_value_is_readable(value: object, text: str) -> None:
    assert numbers.readable(value) == text
