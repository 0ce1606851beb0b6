"""A salt is 64 hexadecimal digits."""

from __future__ import annotations

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.salt import parse_salt, salt_of


@pytest.mark.parametrize("text", ["", "0a" * 32])
def test_a_salt_or_none(text: str) -> None:
    assert parse_salt(text) == text


@pytest.mark.parametrize("text", ["0A" * 32, "0a" * 31, "0a" * 33, "x" * 64, " " + "0a" * 32, "é" * 64])
def test_a_salt_of_the_wrong_form_is_refused(text: str) -> None:
    with pytest.raises(BenchError) as error:
        parse_salt(text)
    assert error.value.code == "bad-salt"
    assert "is not 64 hexadecimal digits (0 to 9, a to f)." in str(error.value)


@pytest.mark.parametrize(
    ("data", "salt"),
    [(b"0a" * 32 + b"\n", "0a" * 32), (b"0a" * 32, None), (b"0A" * 32 + b"\n", None), (b"\xff\n", None)],
)
def test_the_file_of_a_salt_has_a_line_end(data: bytes, salt: str | None) -> None:
    assert salt_of(data) == salt
