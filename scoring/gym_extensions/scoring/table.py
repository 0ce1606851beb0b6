"""The paper's own table: four columns a task, of raw returns, and the group's total."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gym_extensions.scoring.normal import stage_returns
from gym_extensions.scoring.results import Results
from gym_extensions.scoring.run import deviation

COLUMNS = {
    "fully_trained": "Fully Trained",
    "after_env_training": "After Env Training",
    "first_step": "First Step",
    "single_env": "Single Env",
}
"""The paper's columns: R[T][j], R[j][j], R[j−1][j], S[j]."""

Cell = dict[str, float]


def _pooled(episodes: Sequence[float]) -> Cell:
    return {"mean": math.fsum(episodes) / len(episodes), "std": deviation(episodes)}


def table(results: Results) -> list[dict[str, list[float] | None]]:
    """All episodes of every task's four cells, all runs pooled; None where the entry has no such log."""
    sequential, single = stage_returns(results, "sequential"), stage_returns(results, "single")
    rows: list[dict[str, list[float] | None]] = []
    for index in range(len(results.group.tasks)):
        stage = {"fully_trained": -1, "after_env_training": index + 1, "first_step": index}
        row: dict[str, list[float] | None] = {
            name: [value for run in sequential for value in run[s][index]] if sequential else None
            for name, s in stage.items()
        }
        row["single_env"] = [value for run in single for value in run[0][index]] if single else None
        rows.append(row)
    return rows


def table_rows(results: Results) -> list[dict[str, object]]:
    """A row a task: its id, and mean and population standard deviation of each column's episodes, or null."""
    return [
        {"task": task, **{name: _pooled(cell) if cell else None for name, cell in row.items()}}
        for task, row in zip(results.group.task_ids, table(results), strict=True)
    ]


def table_total(results: Results) -> dict[str, Cell | None]:
    """The group's total by column: mean of the rows' means; deviation of all the group's episodes pooled."""
    rows = table(results)
    total: dict[str, Cell | None] = {}
    for name in COLUMNS:
        cells = [cell for row in rows if (cell := row[name]) is not None]
        if cells:
            mean = math.fsum(_pooled(cell)["mean"] for cell in cells) / len(cells)
            total[name] = {"mean": mean, "std": deviation([value for cell in cells for value in cell])}
        else:
            total[name] = None
    return total
