"""Runs docs/results.md and writes its outputs and tables anew: ``python tests/results/page.py``."""

from __future__ import annotations

import ast
import contextlib
import inspect
import re
from pathlib import Path

import pandas as pd

from gym_extensions import results

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "results.md"
CELL = re.compile(r"```python\n(?P<code>.*?)```\n\n```text\n.*?```", re.DOTALL)
TABLE = re.compile(r"<!-- columns: (?P<name>\w+) -->\n.*?<!-- end -->", re.DOTALL)


def column_rows(name: str) -> list[list[str]]:
    """The rows (column, dtype, value) of the table in the docstring of a public function."""
    docstring = (inspect.getdoc(getattr(results, name)) or "").replace("``", "`")
    table = re.split(r"^=+(?: +=+)+$\n", docstring, flags=re.MULTILINE)[2]
    rows = [re.split(r" {2,}", line, maxsplit=2) for line in table.splitlines()]
    return [[column.strip("`"), dtype, value] for column, dtype, value in rows]


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


def with_tables(page: str) -> str:
    """The page with the tables of columns as in the docstrings."""

    def table(match: re.Match[str]) -> str:
        rows = "\n".join(
            f"| `{name}` | {dtype} | {value} |" for name, dtype, value in column_rows(match["name"])
        )
        head = "| column | dtype | value |\n|---|---|---|"
        return f"<!-- columns: {match['name']} -->\n{head}\n{rows}\n<!-- end -->"

    return TABLE.sub(table, page)


if __name__ == "__main__":
    PAGE.write_text(with_tables(executed(PAGE.read_text(encoding="utf-8"))), encoding="utf-8")
