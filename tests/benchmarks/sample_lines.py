"""Newcomer's test: one line of code from each of twenty modules, to guess the folder that it is from.

Run by hand: ``python tests/benchmarks/sample_lines.py SEED``, write the guesses down, then add ``--answers``.
CONTRIBUTING.md has the last result.
"""

from __future__ import annotations

import argparse
import ast
import random
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCE_ROOTS = ("envs", "scoring", "baselines", "site")
MODULES = 20
SHORTEST = 30


def code_lines(path: Path) -> list[tuple[int, str]]:
    """Line numbers and stripped lines of a module, without imports, docstrings, comments and short lines."""
    text = path.read_text("utf-8")
    skipped: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        is_docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if isinstance(node, ast.Import | ast.ImportFrom | ast.Expr) and (
            is_docstring or not isinstance(node, ast.Expr)
        ):
            skipped.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    lines = ((number, line.strip()) for number, line in enumerate(text.splitlines(), 1))
    return [
        (number, line)
        for number, line in lines
        if number not in skipped and len(line) >= SHORTEST and not line.startswith("#")
    ]


def main() -> None:
    """Prints the sampled lines, or their files and line numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seed", type=int)
    parser.add_argument("--answers", action="store_true", help="print files instead of lines")
    options = parser.parse_args()
    generator = random.Random(options.seed)
    modules = sorted(
        path
        for root in SOURCE_ROOTS
        for path in (ROOT / root).rglob("*.py")
        if path.name != "__init__.py" and code_lines(path)
    )
    for index, path in enumerate(generator.sample(modules, MODULES), 1):
        number, line = generator.choice(code_lines(path))
        print(f"{index:2} {f'{path.relative_to(ROOT)}:{number}' if options.answers else line}")  # noqa: T201


if __name__ == "__main__":
    main()
