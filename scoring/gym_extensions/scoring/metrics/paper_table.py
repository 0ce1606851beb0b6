"""The table of Henderson et al. 2017: four columns per task, of raw returns, and the group's totals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from gym_extensions.scoring.documents import about
from gym_extensions.scoring.metrics.returns import Results
from gym_extensions.scoring.statistics.descriptive import standard_deviation

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
