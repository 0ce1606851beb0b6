"""An extension of griffe: docstrings as Markdown, and public names that a module shares."""

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
    """Rewrites every docstring as it is read, also of a module that :meth:`on_package` hides."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """Shows the function ``make`` of a package that also has a module ``make``, which griffe prefers."""
        for module in [pkg, *(each for each in pkg.modules.values() if not each.is_alias)]:
            public = {str(name): module.imports.get(str(name), "") for name in module.exports or ()}
            shared = {target.rpartition(".")[0] for name, target in public.items() if name in module.modules}
            names = [name for name, target in public.items() if target.rpartition(".")[0] in shared - {""}]
            found = {name: pkg.modules_collection[public[name]] for name in names}
            for name, each in found.items():
                module.set_member(name, griffe.Alias(name, each, parent=module))
