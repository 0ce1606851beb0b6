"""The table of Henderson et al. 2017: of raw returns, and as printed, with findings about it."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import msgspec

from gym_extensions.catalog.tasks import NAMESPACE
from gym_extensions.metrics import formulas, statistics
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring import scorecard
from gym_extensions.scoring.scorecard import PAPER_COLUMNS, PaperCell, PaperColumns, PaperRow
from gym_extensions.scoring.submission.normalization import GroupReturns
from gym_extensions.submissions.review import REPORTED


def paper_table(results: GroupReturns) -> tuple[tuple[PaperRow, ...], PaperColumns]:
    """The rows of a group with the episodes of all runs pooled, and the mean and pooled deviation of all."""
    sequential, single = (results.returns.get(protocol, ()) for protocol in ("sequential", "single"))
    rows: list[dict[str, PaperCell | None]] = []
    pooled: dict[str, list[float]] = {column: [] for column in PAPER_COLUMNS}
    for index in range(len(results.group.tasks)):
        stages = (("fully_trained", -1), ("after_env_training", index + 1), ("first_step", index))
        episodes = {name: [x for run in sequential for x in run[stage][index]] for name, stage in stages}
        episodes["single_env"] = [value for run in single for value in run[0][index]]
        rows.append(dict.fromkeys(episodes))
        for column, values in episodes.items():
            pooled[column] += values
            if values:
                mean = math.fsum(values) / len(values)
                rows[-1][column] = PaperCell(mean, statistics.standard_deviation(values))
    total: dict[str, PaperCell | None] = {}
    for column, values in pooled.items():
        means = [cell.mean for row in rows if (cell := row[column])]
        mean = math.fsum(means) / len(means) if means else 0.0
        total[column] = PaperCell(mean, statistics.standard_deviation(values)) if means else None
    table = zip(results.group.task_ids, rows, strict=True)
    return tuple(PaperRow(task, "", **row) for task, row in table), PaperColumns(**total)


PRINTED_COLUMNS = {column.removesuffix("_training"): column for column in PAPER_COLUMNS}
"""The CSV file's columns -> the scorecard's."""
GROUP_NAMES = {"_body_parts": "-body", "_sensor_wall": "-wall", "standup_and_run": "standup-run", "_": "-"}
"""Replacements, in this order, that turn a group's name in the file into its id."""
TOTAL = "TOTAL"
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


def reported_groups(name: str, budget: str) -> dict[str, dict[str, scorecard.GroupScore]]:
    """The scores of a published table by group id, under the protocol ``sequential`` alone."""
    printed: dict[str, dict[str, dict[str, PaperCell]]] = {}
    with table_path(name).open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            cells = printed.setdefault(group_id(row["group"]), {}).setdefault(row["env"], {})
            cells[PRINTED_COLUMNS[row["column"]]] = PaperCell(float(row["mean"]), float(row["std"]))
    found = findings(name)
    groups = {}
    for group, environments in printed.items():
        total = PaperColumns(**environments.pop(TOTAL, {}))
        rows = tuple(PaperRow(task_id(env), env, **cells) for env, cells in environments.items())
        score = scorecard.GroupScore(
            level=REPORTED,
            budget=budget,
            runs=(),
            tasks=tuple(row.task for row in rows),
            metrics={metric.name: MetricValue(why=WHY) for metric in formulas.METRICS["sequential"]},
            reference={row.task: scorecard.ReferenceValue() for row in rows},
            return_matrix=(),
            paper_table=rows,
            paper_total=found[group].paper_total,
            printed_total=total,
            notes=found[group].contradictions,
        )
        groups[group] = {"sequential": score}
    return groups
