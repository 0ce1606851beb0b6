"""The salt of an audit sample: a value that exists only after the log is fixed."""

from __future__ import annotations

import re

from gym_extensions.errors import BenchError

SALT = re.compile("[0-9a-f]{64}")


def parse_salt(text: str, where: str = "--salt") -> str:
    """The salt. An empty text stands for none.

    Raises:
        BenchError: it is not 64 hexadecimal digits.
    """
    if text and not SALT.fullmatch(text):
        shown = repr(text if len(text) <= 80 else f"{text[:80]}…")
        hint = "Use a public value that was fixed after the submission, such as a SHA-256 digest."
        raise BenchError("bad-salt", f"{shown} is not 64 hexadecimal digits (0 to 9, a to f).", where, hint)
    return text


def require_salt(text: str, where: str = "salt") -> None:
    """Raises ``BenchError`` unless the text is a salt."""
    if not parse_salt(text, where):
        hint = "Use a public value that was fixed after the submission, such as a SHA-256 digest."
        raise BenchError("bad-salt", "Expected 64 hexadecimal digits.", where, hint)


def salt_of(data: bytes) -> str | None:
    """The salt in a file ``salt.txt``; None if it is malformed."""
    text = data.decode("ascii", "replace")
    return text[:-1] if text.endswith("\n") and SALT.fullmatch(text[:-1]) else None
