"""Published tables of results without logs, as data: rows and totals exactly as they are printed."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field

from gym_extensions.catalog.published import TABLES
from gym_extensions.catalog.task import NAMESPACE
from gym_extensions.scoring.references import REFERENCES

COLUMNS = {
    "fully_trained": "fully_trained",
    "after_env": "after_env_training",
    "first_step": "first_step",
    "single_env": "single_env",
}
"""The file's columns -> the scorecard's."""

GROUP_NAMES = (
    ("_body_parts", "-body"),
    ("_sensor_wall", "-wall"),
    ("standup_and_run", "standup-run"),
    ("_", "-"),
)
"""How a group's name in the file becomes ours, in this order."""


@dataclass(frozen=True)
class Printed:
    """A printed mean ± standard deviation over episodes; ``unit`` is that of the deviation's last digit."""

    mean: float
    std: float
    unit: float = 0.01

    def as_dict(self) -> dict[str, float]:
        """Mean and std."""
        return {"mean": self.mean, "std": self.std}


Cells = dict[str, Printed]


@dataclass
class PrintedGroup:
    """One group of a published table: the cells of every environment in order, and the printed totals.

    ``rows`` maps the environment's printed name to its cells by column; a column may be missing.
    """

    id: str
    rows: dict[str, Cells] = field(default_factory=dict)
    total: Cells = field(default_factory=dict)

    def column(self, name: str) -> list[Printed]:
        """The cells of a column, in order; empty where the table does not have it."""
        return [cells[name] for cells in self.rows.values() if name in cells]


def task_id(printed: str) -> str:
    """Our id of an environment by its printed name: ``Hopper-v1`` is ``gym_extensions/Hopper-v0``."""
    return f"{NAMESPACE}/{printed.rsplit('-v', 1)[0]}-v0"


def _group_id(name: str) -> str:
    for old, new in GROUP_NAMES:
        name = name.replace(old, new)
    return f"{name}-v0"


def _printed(row: dict[str, str]) -> Printed:
    digits = len(row["std"].partition(".")[2])
    return Printed(float(row["mean"]), float(row["std"]), 10.0**-digits)


def printed_groups(name: str) -> dict[str, PrintedGroup]:
    """The groups of a published table by our ids, in the order of the file."""
    groups: dict[str, PrintedGroup] = {}
    with (REFERENCES / TABLES[name]).open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            found = groups.setdefault(_group_id(row["group"]), PrintedGroup(_group_id(row["group"])))
            cells = found.total if row["env"] == "TOTAL" else found.rows.setdefault(row["env"], {})
            cells[COLUMNS[row["column"]]] = _printed(row)
    return groups
