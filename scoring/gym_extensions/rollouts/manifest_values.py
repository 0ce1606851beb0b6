"""The kinds of values in submission.toml, and the error message of a value of another kind."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from gym_extensions.rollouts.problem import quote

Scalar = str | int | float | bool
Hyperparameter = Scalar | list[Scalar]

TEXT = "a string"
COUNT = "an integer from 0"
FLAG = "true or false"
URL = "a web address or an empty string"
NAMES = "a list of strings"
DIGEST = "a SHA-256 digest of 64 hexadecimal digits, or an empty string"

SHORT, LONG = 100, 4000
"""Most characters of a string; most elements of a list is ``SHORT`` too."""
MAX_COUNT = 2**53 - 1
HYPERPARAMETER = "a string, a finite number, true or false, or a list of them"
LABEL = "[A-Za-z0-9]([A-Za-z0-9-]*[A-Za-z0-9])?"
WEB = re.compile(rf"(https?://{LABEL}(\.{LABEL})*(:[0-9]{{1,5}})?(/[!#-&(-;=?-\[\]-~]*)?)?")
"""The host has ASCII letters, digits, dots and dashes, so that none looks like another. The path has
printable ASCII characters except quotes, angle brackets and backslashes."""


@dataclass(frozen=True)
class Key:
    """A key of submission.toml, with the kind, choices (empty for any) and most characters of its value."""

    kind: str
    choices: tuple[Scalar, ...] = ()
    max_length: int = SHORT
    required: bool = True

    @property
    def wanted(self) -> str:
        """The kind, with the limit of a string."""
        return f"{TEXT} of at most {self.max_length} characters" if self.kind == TEXT else self.kind


def _count_error(value: object, max_length: int) -> str:
    is_count = isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= MAX_COUNT
    return "" if is_count else f"{quote(value)} is not an integer from 0 to 2⁵³ − 1."


def _flag_error(value: object, max_length: int) -> str:
    return "" if isinstance(value, bool) else f"{quote(value)} is not true or false."


def _names_error(value: object, max_length: int) -> str:
    names = value if isinstance(value, list) and len(value) <= SHORT else [None]
    is_valid = all(isinstance(name, str) and 0 < len(name) <= max_length for name in names)
    return "" if is_valid else f"{quote(value)} is not a list of strings of 1 to {max_length} characters."


def _text_error(value: object, max_length: int) -> str:
    if not isinstance(value, str):
        return f"{quote(value)} is not a string."
    return (
        ""
        if len(value) <= max_length
        else f"The string has {len(value)} characters; the limit is {max_length}."
    )


def _url_error(value: object, max_length: int) -> str:
    is_web = isinstance(value, str) and WEB.fullmatch(value)
    other = (
        ""
        if is_web
        else f"{quote(value)} is not a web address in ASCII that starts with https:// or http://."
    )
    return _text_error(value, max_length) or other


def _digest_error(value: object, max_length: int) -> str:
    is_digest = isinstance(value, str) and re.fullmatch("([0-9a-f]{64})?", value)
    return "" if is_digest else f"{quote(value)} is not 64 hexadecimal digits (0 to 9, a to f)."


ERRORS: dict[str, Callable[[object, int], str]] = {
    COUNT: _count_error,
    DIGEST: _digest_error,
    FLAG: _flag_error,
    NAMES: _names_error,
    TEXT: _text_error,
    URL: _url_error,
}


def value_error(key: Key, value: object) -> str:
    """What is wrong with the kind or length of a key's value, or an empty string. Ignores ``choices``."""
    return ERRORS[key.kind](value, key.max_length)


def hyperparameter_error(value: object, *, is_element: bool = False) -> str:
    """The reason why a value cannot be a hyperparameter, as the rest of a sentence, or empty if it can.

    Args:
        value: a value of TOML, or a tuple, which TOML stores as a list.
        is_element: whether it is an element of a list.
    """
    if isinstance(value, list | tuple) and not is_element:
        if len(value) > SHORT:
            return f"has {len(value)} elements; the limit is {SHORT}"
        return next(filter(None, (hyperparameter_error(element, is_element=True) for element in value)), "")
    if isinstance(value, str):
        return f"has {len(value)} characters; the limit is {LONG}" if len(value) > LONG else ""
    if isinstance(value, float):
        return "" if math.isfinite(value) else "is not finite"
    if isinstance(value, int):
        return "" if abs(value) < 2**63 else "is too large"
    container = "contains an element" if is_element else "is"
    return f"{container} of type {type(value).__name__}"
