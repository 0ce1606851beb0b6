"""Published tables without logs, with printed rows and totals, recomputed totals and contradictions."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from gym_extensions.catalog.published import TABLES
from gym_extensions.catalog.task import NAMESPACE
from gym_extensions.scoring.metrics.paper_table import PaperCell, PaperColumns, PaperRow

DATA = Path(__file__).parent / "data"

COLUMNS = {
    "fully_trained": "fully_trained",
    "after_env": "after_env_training",
    "first_step": "first_step",
    "single_env": "single_env",
}
"""The CSV file's columns -> the scorecard's."""

GROUP_NAMES = (
    ("_body_parts", "-body"),
    ("_sensor_wall", "-wall"),
    ("standup_and_run", "standup-run"),
    ("_", "-"),
)
"""Replacements, in this order, that turn a group's name in the file into its id."""

TOTAL = "TOTAL"


@dataclass(frozen=True)
class Finding:
    """What was computed once from a group's printed numbers. tests/scoring/published computes it again."""

    paper_total: PaperColumns
    contradictions: tuple[str, ...]


@dataclass(frozen=True)
class Findings:
    """The findings on a published table by group id."""

    groups: dict[str, Finding]


@dataclass
class PrintedGroup:
    """One group, with cells by printed name of the environment and column, and printed totals by column."""

    rows: dict[str, dict[str, PaperCell]] = field(default_factory=dict)
    total: dict[str, PaperCell] = field(default_factory=dict)

    def table(self) -> tuple[PaperRow, ...]:
        """The rows with task ids."""
        return tuple(PaperRow(task_id(name), name, **cells) for name, cells in self.rows.items())


def task_id(printed: str) -> str:
    """The task id of an environment's printed name, e.g. ``gym_extensions/Hopper-v0`` for ``Hopper-v1``."""
    return f"{NAMESPACE}/{printed.rsplit('-v', 1)[0]}-v0"


def group_id(name: str) -> str:
    """The group id of a group's name in the file."""
    for old, new in GROUP_NAMES:
        name = name.replace(old, new)
    return f"{name}-v0"


def table_path(name: str) -> Path:
    """The CSV file of a published table."""
    return DATA / TABLES[name]


def printed_groups(name: str) -> dict[str, PrintedGroup]:
    """The groups of a published table by id, in the order of the file."""
    groups: dict[str, PrintedGroup] = {}
    with table_path(name).open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            group = groups.setdefault(group_id(row["group"]), PrintedGroup())
            cells = group.total if row["env"] == TOTAL else group.rows.setdefault(row["env"], {})
            cells[COLUMNS[row["column"]]] = PaperCell(float(row["mean"]), float(row["std"]))
    return groups


def findings(name: str) -> dict[str, Finding]:
    """The recomputed totals and the contradictions of a published table by group id."""
    data = table_path(name).with_suffix(".json").read_bytes()
    return msgspec.json.decode(data, type=Findings).groups
