"""Writes docs/adr/README.md, the index of the decisions, from their titles and status lines.

Run it after adding a record or changing a status: ``python docs/adr/index.py``. A test fails if it is stale.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
HEADER = """# Decisions

<!-- Written by docs/adr/index.py. -->

Each record states a decision, the reason and the consequences. A record is not rewritten when the decision
changes: a new record supersedes it, and both status lines say so (`Status: superseded by ADR 56`,
`Status: accepted, supersedes ADR 45 and ADR 55`). The number of a record is never used again.

| number | title | status | superseded by |
| ---: | --- | --- | --- |
"""


@dataclass(frozen=True)
class Record:
    """One decision: number, file name, title, status line, and the records it replaces or is replaced by."""

    number: int
    file: str
    title: str
    status: str
    supersedes: tuple[int, ...]
    superseded_by: tuple[int, ...]


def _numbers(pattern: str, text: str) -> tuple[int, ...]:
    match = re.search(pattern, text)
    return tuple(int(number) for number in re.findall(r"\bADR (\d+)", match[1])) if match else ()


def read(path: Path) -> Record:
    """The record in a file named ``0001-title.md``; SystemExit if its title or status line is missing."""
    text = path.read_text("utf-8")
    title = re.match(r"# (\d+)\. (.+)\n", text)
    status = re.search(r"^\**Status[:.]\**:? *(.+)$", text, flags=re.MULTILINE)
    if title is None or int(title[1]) != int(path.name[:4]):
        raise SystemExit(f"{path.name}: the first line must be '# {int(path.name[:4])}. Title'.")
    if status is None:
        raise SystemExit(f"{path.name}: add a line 'Status: accepted' below the title.")
    header = text.partition("**Context")[0]
    return Record(
        int(title[1]),
        path.name,
        title[2],
        status[1],
        supersedes=_numbers(r"[Ss]upersedes ([^;\n]*)", header),
        superseded_by=_numbers(r"superseded by ([^;]*)", status[1]),
    )


def records() -> list[Record]:
    """All records, in the order of their numbers."""
    return [read(path) for path in sorted(FOLDER.glob("[0-9]*.md"))]


def index(decisions: list[Record]) -> str:
    """The index as Markdown."""
    file = {record.number: record.file for record in decisions}
    rows = []
    for record in decisions:
        links = ", ".join(f"[ADR {n}]({file.get(n, f'missing-{n}')})" for n in record.superseded_by)
        state = "superseded" if record.superseded_by else record.status.split(",")[0].rstrip(".")
        rows.append(f"| {record.number} | [{record.title}]({record.file}) | {state} | {links} |\n")
    return HEADER + "".join(rows)


if __name__ == "__main__":
    (FOLDER / "README.md").write_text(index(records()), encoding="utf-8", newline="\n")
