"""The scores of a published table, which has cells and contradictions, and no metrics."""

from __future__ import annotations

from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.paper_table import PaperColumns
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.published.tables import Finding, PrintedGroup, findings, printed_groups
from gym_extensions.scoring.scorecard.model import GroupScore, ReferenceValue

WHY = "Reported from a publication: other environments, one run, no floor and no matrix."
MISSING = ("logs", "5 runs", "the evaluation matrix", "training curves")


def _group(group: PrintedGroup, finding: Finding, budget: str) -> GroupScore:
    rows = group.table()
    return GroupScore(
        budget=budget,
        runs=(),
        tasks=tuple(row.task for row in rows),
        metrics={metric.name: MetricValue(why=WHY) for metric in METRICS["sequential"]},
        reference={row.task: ReferenceValue(None, None, None) for row in rows},
        return_matrix=(),
        missing_for_full_entry=MISSING,
        paper_table=rows,
        paper_total=finding.paper_total,
        printed_total=PaperColumns(**group.total),
        notes=finding.contradictions,
    )


def reported_groups(name: str, budget: str) -> dict[str, dict[str, GroupScore]]:
    """The scores of a published table by group id, under the protocol ``sequential`` alone."""
    results = findings(name)
    return {
        group_id: {"sequential": _group(group, results[group_id], budget)}
        for group_id, group in printed_groups(name).items()
    }
