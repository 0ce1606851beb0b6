"""A published table as printed, and totals of its rows."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from gym_extensions.scoring.entry.reported_tables import PRINTED_COLUMNS, TOTAL, group_id, table_path


@dataclass(frozen=True)
class Printed:
    """A printed mean ± standard deviation."""

    mean: float
    std: float


@dataclass
class PrintedGroup:
    """One group: cells by environment and column, and the printed totals by column."""

    id: str
    rows: dict[str, dict[str, Printed]] = field(default_factory=dict)
    total: dict[str, Printed] = field(default_factory=dict)

    def column(self, name: str) -> list[Printed]:
        """The cells of a column, in order; empty where the table does not have it."""
        return [cells[name] for cells in self.rows.values() if name in cells]


def printed_groups(name: str) -> dict[str, PrintedGroup]:
    """The groups of a published table by id, with the digits as printed."""
    groups: dict[str, PrintedGroup] = {}
    with table_path(name).open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            key = group_id(row["group"])
            group = groups.setdefault(key, PrintedGroup(key))
            cells = group.total if row["env"] == TOTAL else group.rows.setdefault(row["env"], {})
            cells[PRINTED_COLUMNS[row["column"]]] = Printed(float(row["mean"]), float(row["std"]))
    return groups


def row_mean(cells: Sequence[Printed]) -> float:
    """The mean of the rows' means."""
    return math.fsum(cell.mean for cell in cells) / len(cells)


def pooled(cells: Sequence[Printed]) -> float:
    """The standard deviation of all episodes together: √(mean(σ²) + population variance of the means)."""
    center = row_mean(cells)
    return math.sqrt(math.fsum(_square(cell, center) for cell in cells) / len(cells))


def _square(cell: Printed, center: float) -> float:
    """Mean square of a row's episodes about a center; the last bit of ``pow`` would depend on the machine."""
    gap = cell.mean - center
    return cell.std * cell.std + gap * gap
