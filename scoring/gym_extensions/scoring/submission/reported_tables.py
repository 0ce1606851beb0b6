"""The table of Henderson et al. 2017: of raw returns, and as printed, with findings about it."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from gym_extensions.catalog.tasks import NAMESPACE
from gym_extensions.metrics import formulas, statistics
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.group_score import (
    PAPER_COLUMNS,
    GroupScore,
    PaperCell,
    PaperColumns,
    PaperRow,
    ReferenceValue,
)
from gym_extensions.scoring.submission.normalization import GroupReturns
from gym_extensions.submissions.review import REPORTED


def paper_table(results: GroupReturns) -> tuple[tuple[PaperRow, ...], PaperColumns]:
    """The rows of a group with the episodes of all runs pooled, and the mean and pooled deviation of all."""
    sequential, single = (results.returns.get(protocol, ()) for protocol in ("sequential", "single"))

    def episodes(column: str, index: int) -> list[float]:
        if column == "single_env":
            return [value for run in single for value in run[0][index]]
        stage = {"fully_trained": -1, "after_env_training": index + 1, "first_step": index}[column]
        return [value for run in sequential for value in run[stage][index]]

    rows, total = [], {}
    for index, task in enumerate(results.group.task_ids):
        cells = {column: _cell(episodes(column, index)) for column in PAPER_COLUMNS}
        rows.append(PaperRow(task, "", **cells))
    for column in PAPER_COLUMNS:
        pooled = _cell([value for index in range(len(rows)) for value in episodes(column, index)])
        mean = statistics.mean(cell.mean for row in rows if (cell := row.cell(column)))
        total[column] = PaperCell(mean, pooled.std) if pooled and mean is not None else None
    return tuple(rows), PaperColumns(**total)


def _cell(values: Sequence[float]) -> PaperCell | None:
    mean = statistics.mean(values)
    return None if mean is None else PaperCell(mean, statistics.standard_deviation(values))


PRINTED_COLUMNS = {column.removesuffix("_training"): column for column in PAPER_COLUMNS}
"""The CSV file's columns -> the scorecard's."""
GROUP_NAMES = {"_body_parts": "-body", "_sensor_wall": "-wall", "standup_and_run": "standup-run", "_": "-"}
"""Replacements, in this order, that turn a group's name in the file into its id."""
WHY = "Reported from a publication: other environments, one run, no floor and no matrix."


@dataclass(frozen=True)
class Finding:
    """What follows from the printed numbers of a group, frozen."""

    paper_total: PaperColumns
    contradictions: tuple[str, ...]


def task_id(printed: str) -> str:
    """The task id of an environment's printed name: ``gym_extensions/Hopper-v0`` for ``Hopper-v1``."""
    return f"{NAMESPACE}/{printed.rsplit('-v', 1)[0]}-v0"


def group_id(name: str) -> str:
    """The group id of a group's name in the file."""
    for old, new in GROUP_NAMES.items():
        name = name.replace(old, new)
    return f"{name}-v0"


def table_path(name: str) -> Path:
    """The CSV file of a published table; its findings lie beside it."""
    return Path(__file__).parents[1] / "published_data" / f"{name}.csv"


def findings(name: str) -> dict[str, Finding]:
    """The recomputed totals and the contradictions of a published table by group id."""
    document = msgspec.json.decode(table_path(name).with_suffix(".json").read_bytes())
    return msgspec.convert(document["groups"], dict[str, Finding])


def reported_groups(name: str, budget: str) -> dict[str, dict[str, GroupScore]]:
    """The scores of a published table by group id, under the protocol ``sequential`` alone."""
    printed: dict[str, dict[str, dict[str, PaperCell]]] = {}
    with table_path(name).open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            cells = printed.setdefault(group_id(row["group"]), {}).setdefault(row["env"], {})
            cells[PRINTED_COLUMNS[row["column"]]] = PaperCell(float(row["mean"]), float(row["std"]))
    found = findings(name)
    groups = {}
    for group, environments in printed.items():
        total = PaperColumns(**environments.pop("TOTAL", {}))
        rows = tuple(PaperRow(task_id(env), env, **cells) for env, cells in environments.items())
        score = GroupScore(
            level=REPORTED,
            budget=budget,
            runs=(),
            tasks=tuple(row.task for row in rows),
            metrics={metric.name: MetricValue(why=WHY) for metric in formulas.METRICS["sequential"]},
            reference={row.task: ReferenceValue() for row in rows},
            return_matrix=(),
            paper_table=rows,
            paper_total=found[group].paper_total,
            printed_total=total,
            notes=found[group].contradictions,
        )
        groups[group] = {"sequential": score}
    return groups
