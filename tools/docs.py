"""Writes every page of docs/ that is generated: ``make docs``. Pictures and findings have their own commands.

* The lines between ``<!-- table: NAME -->`` and ``<!-- end -->``: metrics, keys of documents, rules, columns.
* The outputs of docs/results.md, whose code is run.
* docs/environments and the catalog's descriptions of tasks (``tools.environments``).
* The tables of docs/experts.md (``tools.experts``).
"""

import ast
import contextlib
import dataclasses
import inspect
import re
from collections.abc import Iterable, Sequence
from typing import Any, get_args

import pandas as pd

from gym_extensions import results
from gym_extensions.baselines.algorithms import EXTRAS
from gym_extensions.catalog import variations
from gym_extensions.catalog.bodies import BODIES
from gym_extensions.curation import pull_request_rules
from gym_extensions.documents import json_schema
from gym_extensions.errors import reports_mistakes
from gym_extensions.metrics.formulas import METRICS, NEEDS
from gym_extensions.results.frames import columns_of
from gym_extensions.site.pages.data import DOCUMENTS
from gym_extensions.submissions import rules
from gym_extensions.submissions.manifest import BOX_PACKAGES
from gym_extensions.submissions.problem import Scope
from tools import ROOT, argument_parser
from tools.environments.__main__ import main as write_environments
from tools.experts.__main__ import main as experts

PAGE = ROOT / "docs" / "results.md"
CELL = re.compile(r"```python\n(?P<code>.*?)```\n\n```text\n.*?```", re.DOTALL)
BLOCK = re.compile(r"<!-- table: (?P<name>[^>]+) -->\n.*?<!-- end -->", re.DOTALL)


def executed(page: str) -> str:
    """The page with the output of every block of code, run in order with the same variables."""
    variables: dict[str, object] = {}

    def cell(match: re.Match[str]) -> str:
        *body, last = ast.parse(match["code"]).body
        assert isinstance(last, ast.Expr), match["code"]
        exec(compile(ast.Module(body, []), "results.md", "exec"), variables)
        value = eval(compile(ast.Expression(last.value), "results.md", "eval"), variables)
        return f"```python\n{match['code']}```\n\n```text\n{value}\n```"

    # The options of a script, so that a terminal's width does not change what is printed.
    options = pd.option_context("display.width", 80, "display.max_columns", 20)
    with contextlib.chdir(ROOT), options:
        return CELL.sub(cell, page)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    first, *others = [f"| {' | '.join(line)} |" for line in (head, *rows)]
    return "\n".join([first, f"|{'---|' * len(head)}", *others])


def metric_rows(protocol: str) -> list[list[str]]:
    """Name with title, formula, direction, needs and other names of every metric of a protocol."""
    return [
        [
            f"`{each.name}` {each.title}",
            each.formula,
            each.better or "not ranked",
            ", ".join(NEEDS[name] for name in each.needs if name in NEEDS),
            each.known_as,
        ]
        for each in METRICS[protocol]
    ]


def key_rows(definition: dict[str, Any], definitions: dict[str, Any]) -> list[list[str]]:
    """An object's keys. A key without a description has the first paragraph of its type's."""
    rows = []
    for name, field in definition["properties"].items():
        text = str(field.get("description", ""))
        if not text and "$ref" in field:
            text = str(definitions[field["$ref"].rpartition("/")[2]]["description"])
            text = " ".join(text.partition("\n\n")[0].split())
            text = text[:1].lower() + text[1:].rstrip(".")
        rows.append([f"`{name}`", text])
    return rows


def variation_rows() -> list[list[str]]:
    """The name in TOML files, arguments, summary and bodies of every variation."""
    rows = []
    for kind in [variations.KINDS[name] for name in variations.KINDS if name in variations.__all__]:
        arguments = ", ".join(
            f"`{each.name}`" + ("" if each.default is dataclasses.MISSING else f" = {each.default}")
            for each in dataclasses.fields(kind)
        )
        summary = " ".join((inspect.getdoc(kind) or "").partition("\n\n")[0].replace("``", "`").split())
        bodies = [name for name, body in BODIES.items() if kind.fits(body)]
        others = [name for name in BODIES if name not in bodies]
        fitting = f"all but {' and '.join(others)}" if len(others) < 3 else ", ".join(bodies)
        rows.append([f"`{kind.__name__}`", arguments.replace("False", "false"), summary, fitting])
    return rows


def tables() -> dict[str, str]:
    """Every generated table by its name."""
    by_scope = sorted(rules.RULES.values(), key=lambda rule: get_args(Scope).index(rule.scope))
    of_pull_requests = pull_request_rules.RULES.values()
    extra_of = {module: f"`{extra}`" for extra, modules in EXTRAS.items() for module in modules}
    extras = ([f"`{name}`", extra_of.get(name.replace("-", "_"), "")] for name in BOX_PACKAGES)
    found = {
        "rules": table(("rule", "text"), ([f"`{rule.name}`", rule.text] for rule in by_scope)),
        "rules of pull requests": table(
            ("rule", "text"), ([f"`{rule.name}`", rule.text] for rule in of_pull_requests)
        ),
        "packages of the box": table(("package", "extra"), extras),
        "variations": table(("`kind`", "arguments", "what it does", "bodies"), variation_rows()),
    }
    names = ("metric", "formula", "better", "also needs", "also known as")
    orders = ("descending", "balanced")  # they have the metrics of sequential
    found |= {f"metrics {name}": table(names, metric_rows(name)) for name in METRICS if name not in orders}
    for document in DOCUMENTS.values():
        parts = json_schema(document)["$defs"]
        keys = {name: key_rows(part, parts) for name, part in parts.items()}
        found |= {f"keys {name}": table(("key", "value"), rows) for name, rows in keys.items()}
    for name in results.__all__:
        if "  =====" in (getattr(results, name).__doc__ or ""):
            columns = columns_of(getattr(results, name))
            rows = [[f"`{column}`", *others] for column, *others in columns]
            found[f"columns {name}"] = table(("column", "dtype", "value"), rows)
    return found


def updated(page: str) -> str:
    """The page with its tables updated. Raises KeyError for a table that does not exist."""
    texts = tables()
    return BLOCK.sub(
        lambda block: f"<!-- table: {block['name']} -->\n{texts[block['name']]}\n<!-- end -->", page
    )


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the pages."""
    argument_parser("tools.docs", __doc__).parse_args(argv)
    write_environments([])
    experts(["tables"])
    for path in sorted((ROOT / "docs").glob("*.md")):
        text = path.read_text(encoding="utf-8")
        new = updated(executed(text) if path == PAGE else text)
        if new != text:
            path.write_text(new, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
