"""JSON that is quick to write and can be read: objects in lines down to a depth, the rest in one line."""

from __future__ import annotations

import json
from typing import Any

DEEPEST = 7
"""So deep lie the metrics of a scorecard, each in a line of its own."""

_compact = json.JSONEncoder(sort_keys=True, ensure_ascii=False, allow_nan=False).encode


class Made(str):
    """A value of a document that is JSON already, as ``made`` gives it."""


def _lines(value: Any, depth: int, margin: str) -> str:
    inner = f"{margin}  "
    if isinstance(value, Made):
        return value
    if depth and value and isinstance(value, dict):
        items = [f"{inner}{_compact(key)}: {_lines(value[key], depth - 1, inner)}" for key in sorted(value)]
        return "{\n" + ",\n".join(items) + f"\n{margin}}}"
    if depth and isinstance(value, list) and value and isinstance(value[0], (dict, Made)):
        items = [f"{inner}{_lines(item, depth - 1, inner)}" for item in value]
        return "[\n" + ",\n".join(items) + f"\n{margin}]"
    return _compact(value)


def text(document: dict[str, Any]) -> str:
    """The document as JSON: sorted keys, floats by ``repr``, no NaN; raises ValueError for one."""
    return _lines(document, DEEPEST, "") + "\n"


def made(value: Any, depth: int) -> Made:
    """A value that lies so many objects and lists deep in a document, as it stands in the document's text."""
    return Made(_lines(value, DEEPEST - depth, "  " * depth))
