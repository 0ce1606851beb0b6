"""The table of Henderson et al. 2017: of an entry's raw returns, and as printed, with findings about it."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import msgspec

from gym_extensions.catalog.protocol import TABLES
from gym_extensions.catalog.tasks import NAMESPACE
from gym_extensions.scoring.documents import about
from gym_extensions.scoring.returns import Results
from gym_extensions.scoring.statistics import standard_deviation

COLUMNS = {
    "fully_trained": "Fully Trained",
    "after_env_training": "After Env Training",
    "first_step": "First Step",
    "single_env": "Single Env",
}
"""The paper's columns: R[T][j], R[j][j], R[j−1][j], S[j]."""

Episodes = dict[str, list[float] | None]


@dataclass(frozen=True, slots=True)
class PaperCell:
    """Raw returns of episodes, all runs pooled."""

    mean: Annotated[float, about("mean return")]
    std: Annotated[float, about("population standard deviation over episodes")]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperColumns:
    """The four cells of a row or of a total; null where the entry has no such log."""

    fully_trained: Annotated[PaperCell | None, about("after the last stage")] = None
    after_env_training: Annotated[PaperCell | None, about("right after training on the task")] = None
    first_step: Annotated[PaperCell | None, about("right before training on the task")] = None
    single_env: Annotated[PaperCell | None, about("trained on the task alone")] = None

    def cell(self, column: str) -> PaperCell | None:
        """The cell of a column of ``COLUMNS``."""
        cell: PaperCell | None = getattr(self, column)
        return cell

    def cells(self) -> list[PaperCell | None]:
        """The four cells in the order of ``COLUMNS``."""
        return [self.cell(column) for column in COLUMNS]


@dataclass(frozen=True, slots=True)
class PaperRow(PaperColumns):
    """One task's row."""

    task: Annotated[str, about("the task's id")]
    printed_task: Annotated[str, about("its name in the publication; empty in entries with logs")] = ""


def _pooled(episodes: Sequence[float]) -> PaperCell:
    center = math.fsum(episodes) / len(episodes)
    return PaperCell(center, standard_deviation(episodes, center=center))


def _episodes(results: Results) -> list[Episodes]:
    """All episodes of every task's four cells, with all runs pooled. None where the entry has no such log."""
    sequential, single = (results.returns.get(protocol) for protocol in ("sequential", "single"))
    rows: list[Episodes] = []
    for index in range(len(results.group.tasks)):
        stages = {"fully_trained": -1, "after_env_training": index + 1, "first_step": index}
        row: Episodes = {
            name: [value for run in sequential for value in run[stage][index]] if sequential else None
            for name, stage in stages.items()
        }
        row["single_env"] = [value for run in single for value in run[0][index]] if single else None
        rows.append(row)
    return rows


def paper_table(results: Results) -> tuple[tuple[PaperRow, ...], PaperColumns]:
    """The rows and the total of a group.

    A column's total is the mean of its rows' means, and the population standard deviation of all the
    group's episodes pooled.
    """
    episodes = _episodes(results)
    cells = [{name: _pooled(cell) if cell else None for name, cell in row.items()} for row in episodes]
    total: dict[str, PaperCell | None] = {}
    for name in COLUMNS:
        means = [cell.mean for row in cells if (cell := row[name])]
        pooled = [value for row in episodes for value in row[name] or ()]
        total[name] = PaperCell(math.fsum(means) / len(means), standard_deviation(pooled)) if means else None
    rows = zip(results.group.task_ids, cells, strict=True)
    return tuple(PaperRow(task, "", **row) for task, row in rows), PaperColumns(**total)


DATA = Path(__file__).parent / "published_data"

PRINTED_COLUMNS = {
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
            cells[PRINTED_COLUMNS[row["column"]]] = PaperCell(float(row["mean"]), float(row["std"]))
    return groups


def findings(name: str) -> dict[str, Finding]:
    """The recomputed totals and the contradictions of a published table by group id."""
    data = table_path(name).with_suffix(".json").read_bytes()
    return msgspec.json.decode(data, type=Findings).groups
