"""The length of the examples: what the documentation promises, and what the table of examples/README.md says.

A line counts if it has code: blank lines, comments and docstrings do not count. Imports and the ``__main__``
block count.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.py"))
LAYOUT = (
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
)
START, END = "# --- from checkpoints to a submission ---", "# --- end ---"
IMPORTS = r"^from gym_extensions.*\n"
MOST_LINES = {"checkpoints": 15, "multi_head": 40, "own_suite": 12}
"""Limits on the whole file; of ``checkpoints``, on our imports and the code between the marks. The rest
of that file stands for the user's network and training."""


def code_lines(text: str) -> int:
    """The number of lines with code."""
    docstrings = {
        line
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node)
        for line in range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1)
    }
    tokens = [
        token for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in LAYOUT
    ]
    lines = {line for token in tokens for line in range(token.start[0], token.end[0] + 1)}
    return len(lines - docstrings)


def own_code(name: str) -> str:
    """The code that a user writes."""
    text = (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")
    if START not in text:
        return text
    imports = "".join(re.findall(IMPORTS, text, flags=re.MULTILINE))
    return imports + text.partition(START)[2].partition(END)[0]


def test_blank_lines_comments_and_docstrings_do_not_count() -> None:
    assert code_lines('"""Title.\n\nText.\n"""\n\n# note\nx = (\n    1,\n)  # one\n') == 3


@pytest.mark.parametrize("name", MOST_LINES)
def test_the_example_is_as_short_as_promised(name: str) -> None:
    assert 0 < code_lines(own_code(name)) <= MOST_LINES[name]


def test_the_table_has_every_example_and_its_number_of_lines() -> None:
    table = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[(\w+)\.py\]\(\w+\.py\) \|.* \| (\d+) \|$", table, flags=re.MULTILINE)
    assert {name: int(lines) for name, lines in rows} == {name: code_lines(own_code(name)) for name in NAMES}
