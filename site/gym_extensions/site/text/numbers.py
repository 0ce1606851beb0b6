"""Numbers as text: fixed digits, the minus sign of typography, and no negative zero."""

from __future__ import annotations

from collections.abc import Iterable

MINUS = "\N{MINUS SIGN}"
THIN_SPACE = "\N{NARROW NO-BREAK SPACE}"

FORMATS = tuple(f".{digits}f" for digits in range(10))
"""The format of each number of digits. Making it for each of a million numbers takes as long as using it."""


def fixed(value: float, digits: int = 2) -> str:
    """The value with ``digits`` digits after the point and a minus sign; −0.00 becomes 0.00."""
    text = format(value, FORMATS[digits])
    if text.startswith("-"):
        return MINUS + text[1:] if text.strip("-0.") else text[1:]
    return text


def interval(low: float, high: float, digits: int = 2) -> str:
    """Both ends of an interval, for example ``−0.03 to 0.41``."""
    return f"{fixed(low, digits)} to {fixed(high, digits)}"


def digits_for(values: Iterable[float]) -> int:
    """Digits after the point (0, 1 or 2) that show the largest value with about four figures."""
    largest = max((abs(value) for value in values), default=0.0)
    if largest >= 1000:
        return 0
    return 1 if largest >= 10 else 2


def grouped(count: int) -> str:
    """A whole number with spaces between thousands, for example ``10 000``."""
    return f"{count:,}".replace(",", THIN_SPACE).replace("-", MINUS)


def count(number: int, noun: str, plural: str = "") -> str:
    """A number with its noun: ``1 run``, ``2 runs``; ``plural`` where it is not the noun with an s."""
    return f"{grouped(number)} {noun if number == 1 else plural or f'{noun}s'}"


def readable(value: object) -> str:
    """A value of the manifest as text: ``true`` as yes, whole numbers grouped, lists with commas."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return grouped(value)
    if isinstance(value, float):
        return repr(value).replace("-", MINUS)
    if isinstance(value, (list, tuple)):
        return ", ".join(map(readable, value))
    return str(value)
