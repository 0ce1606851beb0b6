"""Whole numbers as text: base64 digits of variable length, as in source maps.

A number is shifted left by one, with its sign in the lowest bit. It is cut into groups of five bits, lowest
first; a digit of 32 or more says that another follows. Small numbers take one character.
"""

from __future__ import annotations

from collections.abc import Iterable

from gym_extensions.errors import BenchError

DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
VALUES = {digit: value for value, digit in enumerate(DIGITS)}
MORE, BITS = 32, 5


def encode(numbers: Iterable[int]) -> str:
    """The text of these whole numbers.

    Example:
        >>> encode([0, 1, -1, 16])
        'ACDgB'
    """
    digits = []
    for number in numbers:
        rest = abs(number) << 1 | (number < 0)
        while rest >= MORE:
            digits.append(DIGITS[rest & (MORE - 1) | MORE])
            rest >>= BITS
        digits.append(DIGITS[rest])
    return "".join(digits)


def decode(text: str) -> list[int]:
    """The whole numbers of a text.

    Raises:
        BenchError: a character is not a digit, or the last number is incomplete.
    """
    numbers, rest, shift = [], 0, 0
    for character in text:
        value = VALUES.get(character)
        if value is None:
            raise BenchError("bad-motion", f"Unexpected character {character!r} in a motion.")
        rest |= (value & (MORE - 1)) << shift
        shift += BITS
        if value < MORE:
            numbers.append(-(rest >> 1) if rest & 1 else rest >> 1)
            rest, shift = 0, 0
    if shift:
        raise BenchError("bad-motion", "The last number of a motion is incomplete.")
    return numbers
