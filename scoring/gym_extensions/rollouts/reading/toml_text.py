"""Parses submission.toml, whose depth is bounded before and after it is parsed."""

from __future__ import annotations

import re
import tomllib
from typing import Any

MAX_NESTING = 8
"""Most levels of nested tables and lists, and most parts of a dotted key."""
QUOTED = re.compile(
    r'"""(?:[^"\\]|\\.?|"(?!""))*+(?:"{3,5}|\Z)'
    r"|'''(?:[^']|'(?!''))*+(?:'{3,5}|\Z)"
    r'|"(?:[^"\\\n]|\\.?)*+(?:"|\Z|(?=\n))'
    r"|'[^'\n]*+'?"
    r"|#[^\n]*+",
    re.DOTALL,
)
"""Strings and comments. What is not closed extends to the end, where the parser stops too; so the search
takes time in proportion to the text."""
BETWEEN_KEYS = re.compile(r"[=\n\[\]{},]")


def parse(data: bytes) -> dict[str, Any]:
    """The tables of a TOML file.

    The depth of dotted keys is checked first, because ``tomllib`` needs memory and time in proportion to the
    square of their parts (https://github.com/python/cpython/issues/149231).

    Raises:
        ValueError: it is not TOML or not UTF-8.
        RecursionError: tables and lists are nested too deeply.
    """
    text = data.decode("utf-8")
    if _longest_key(text) > MAX_NESTING:
        raise RecursionError
    tables = tomllib.loads(text)
    level: list[Any] = [tables]
    for _ in range(MAX_NESTING):
        inner = [value for item in level for value in (item.values() if isinstance(item, dict) else item)]
        level = [value for value in inner if isinstance(value, (dict, list))]
    if level:
        raise RecursionError
    return tables


def _longest_key(text: str) -> int:
    """An upper bound on the parts of dotted keys: dots outside of strings and comments, plus one."""
    return 1 + max(part.count(".") for part in BETWEEN_KEYS.split(QUOTED.sub('""', text)))
