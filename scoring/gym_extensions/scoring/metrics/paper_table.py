"""The paper's own table: four columns a task, of raw returns, and the group's total."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from gym_extensions.scoring.metrics.returns import Results
from gym_extensions.scoring.statistics.descriptive import standard_deviation

COLUMNS = {
    "fully_trained": "Fully Trained",
    "after_env_training": "After Env Training",
    "first_step": "First Step",
    "single_env": "Single Env",
}
"""The paper's columns: R[T][j], R[j][j], R[j−1][j], S[j]."""

Cell = dict[str, float]


def _pooled(episodes: Sequence[float]) -> Cell:
    centre = math.fsum(episodes) / len(episodes)
    return {"mean": centre, "std": standard_deviation(episodes, center=centre)}


def shown_rows(scored: dict[str, Any]) -> list[dict[str, Any]]:
    """The rows of a scored group's table as people read them: the tasks, the total, and a printed total."""
    totals = {"total": scored["total"], "printed total": scored.get("printed_total")}
    return [*scored["table"], *({"task": name, **total} for name, total in totals.items() if total)]


def _episodes(results: Results) -> list[dict[str, list[float] | None]]:
    """All episodes of every task's four cells, all runs pooled; None where the entry has no such log."""
    sequential, single = (results.returns.get(protocol) for protocol in ("sequential", "single"))
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


def table(results: Results) -> tuple[list[dict[str, object]], dict[str, Cell | None]]:
    """The paper's rows and total of a group: mean and population standard deviation of episodes, or null.

    A row is a task's id and its four columns. A column's total is the mean of its rows' means, and the
    deviation of all the group's episodes pooled.
    """
    episodes = _episodes(results)
    cells = [{name: _pooled(cell) if cell else None for name, cell in row.items()} for row in episodes]
    total: dict[str, Cell | None] = {}
    for name in COLUMNS:
        means = [cell["mean"] for row in cells if (cell := row[name])]
        pooled = [value for row in episodes for value in row[name] or ()]
        total[name] = (
            {"mean": math.fsum(means) / len(means), "std": standard_deviation(pooled)} if means else None
        )
    rows: list[dict[str, object]] = [
        {"task": task, **row} for task, row in zip(results.group.task_ids, cells, strict=True)
    ]
    return rows, total
