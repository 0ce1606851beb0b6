"""An extension of griffe that shows the reStructuredText in docstrings as Markdown: roles and simple tables."""

from __future__ import annotations

import re
from typing import Any

import griffe

ROLE = re.compile(r":\w+:`(?:~?[\w.]*\.)?(?P<name>\w+)`")
TABLE = re.compile(r"^=+(?: +=+)+\n(?P<rows>.*?)^=+(?: +=+)+$", re.MULTILINE | re.DOTALL)
COLUMNS = re.compile(r" {2,}")


def as_markdown(docstring: str) -> str:
    """The docstring with roles as code and simple tables as Markdown tables."""

    def table(match: re.Match[str]) -> str:
        lines = [line for line in match["rows"].splitlines() if not line.startswith("=")]
        rows = [" | ".join(COLUMNS.split(line)) for line in lines]
        width = rows[0].count("|") + 1
        return "\n".join(f"| {row} |" for row in (rows[0], " | ".join(["---"] * width), *rows[1:]))

    return ROLE.sub(r"`\g<name>`", TABLE.sub(table, docstring))


class RestructuredText(griffe.Extension):
    """Rewrites every docstring as it is read."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)
