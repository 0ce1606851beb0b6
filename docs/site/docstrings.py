"""An extension of griffe that shows reStructuredText in docstrings, roles and simple tables, as Markdown."""

from __future__ import annotations

import re
from typing import Any

import griffe

ROLE = re.compile(r":\w+:`(?:~?[\w.]*\.)?(?P<name>\w+)`")
RULE = r"=+(?: +=+)+"
TABLE = re.compile(
    rf"^{RULE}\n(?P<head>.+)\n{RULE}\n(?P<rows>(?:(?!=).*\n)*?){RULE}$",
    re.MULTILINE,
)
GAP = re.compile(r" {2,}")


def as_markdown(docstring: str) -> str:
    """The docstring with roles as code and simple tables as Markdown tables."""

    def table(match: re.Match[str]) -> str:
        head = GAP.split(match["head"])
        rows = [GAP.split(row, maxsplit=len(head) - 1) for row in match["rows"].splitlines()]
        return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows))

    return ROLE.sub(r"`\g<name>`", TABLE.sub(table, docstring))


class RestructuredText(griffe.Extension):
    """Rewrites every docstring as it is read."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)
