"""The scorecard of a published table: what it has, what it lacks, and where it contradicts itself."""

from __future__ import annotations

from typing import Any

from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.paper_table import COLUMNS
from gym_extensions.scoring.published.consistency import contradictions, pooled, row_mean
from gym_extensions.scoring.published.tables import PrintedGroup, printed_groups, task_id

Document = dict[str, Any]

WHY = "Reported from a publication: other environments, one run, no floor and no matrix."
LACKS = ("logs", "5 runs", "the evaluation matrix", "training curves")


def _total(group: PrintedGroup) -> Document:
    """Totals recomputed from the rows: mean of means, deviation of all episodes pooled."""
    cells = {name: group.column(name) for name in COLUMNS}
    return {
        name: {"mean": row_mean(found), "std": pooled(found)} if found else None
        for name, found in cells.items()
    }


def _group(group: PrintedGroup, groups: dict[str, PrintedGroup], budget: str) -> Document:
    tasks = [task_id(name) for name in group.rows]
    nothing: Document = {"mean": None, "low": None, "high": None, "runs": [], "why": WHY}
    return {
        "budget": budget,
        "runs": [],
        "tasks": tasks,
        "metrics": {metric.name: dict(nothing) for metric in METRICS["sequential"]},
        "profile": None,
        "iqm": None,
        "reference": {task: {"floor": None, "ceiling": None, "open": None} for task in tasks},
        "matrix": [],
        "missing": list(LACKS),
        "table": [
            {"task": task_id(name), "printed_task": name}
            | {column: cells[column].as_dict() if column in cells else None for column in COLUMNS}
            for name, cells in group.rows.items()
        ],
        "total": _total(group),
        "printed_total": {
            column: group.total[column].as_dict() if column in group.total else None for column in COLUMNS
        },
        "notes": contradictions(group, groups),
    }


def reported_groups(name: str, budget: str) -> Document:
    """The ``groups`` of a reported entry's scorecard by id, each with the protocol ``sequential`` alone."""
    groups = printed_groups(name)
    return {group.id: {"sequential": _group(group, groups, budget)} for group in groups.values()}
