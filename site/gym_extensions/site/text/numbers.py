"""Numbers as text: fixed digits, a true minus sign, never a negative zero."""

from __future__ import annotations

from collections.abc import Iterable

MINUS = "\N{MINUS SIGN}"
THIN_SPACE = "\N{NARROW NO-BREAK SPACE}"


def fixed(value: float, digits: int = 2) -> str:
    """The value with that many digits after the point and a proper minus sign; −0.00 is 0.00."""
    text = f"{value:.{digits}f}"
    if text.startswith("-"):
        return MINUS + text[1:] if text.strip("-0.") else text[1:]
    return text


def interval(low: float, high: float, digits: int = 2) -> str:
    """Both ends of an interval, for example ``−0.03 to 0.41``."""
    return f"{fixed(low, digits)} to {fixed(high, digits)}"


def digits_for(values: Iterable[float]) -> int:
    """Digits after the point that show values of this size in some four figures: 0, 1 or 2."""
    largest = max((abs(value) for value in values), default=0.0)
    if largest >= 1000:
        return 0
    return 1 if largest >= 10 else 2


def grouped(count: int) -> str:
    """A whole number with its thousands set apart, for example ``10 000``."""
    return f"{count:,}".replace(",", THIN_SPACE).replace("-", MINUS)


def ordinary(value: object) -> str:
    """A manifest's value as a reader writes it: ``true`` as yes, whole numbers grouped, lists with commas."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return grouped(value)
    if isinstance(value, float):
        return repr(value).replace("-", MINUS)
    if isinstance(value, (list, tuple)):
        return ", ".join(map(ordinary, value))
    return str(value)
