"""A metric of a scorecard as a mean with its error, for one group or for several groups together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gym_extensions.scoring.metrics.definitions import FINAL, JOINT_GAP
from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.scorecard.model import GroupScore
from gym_extensions.scoring.statistics.intervals import Summary, mean_of_groups, subtract, summary

Groups = Mapping[str, Mapping[str, GroupScore]]
"""Scores by group id and protocol, as in a scorecard."""


def estimate(groups: Groups, names: Sequence[str], protocol: str, metric: Metric) -> Summary | None:
    """The mean over groups of a metric's mean over runs.

    None where it has no value in one of them.

    Args:
        groups: scores by group id and protocol.
        names: ids of the groups, which are independent.
        protocol: ``sequential``, ``single`` or ``joint``.
        metric: a metric of that protocol.
    """
    parts = [_of_group(groups.get(name, {}), protocol, metric) for name in names]
    present = [part for part in parts if part is not None]
    if not present or len(present) < len(parts):
        return None
    return present[0] if len(present) == 1 else mean_of_groups(present)


def _of_group(protocols: Mapping[str, GroupScore], protocol: str, metric: Metric) -> Summary | None:
    if metric is JOINT_GAP:  # not a function of one run: joint and sequential runs are not paired
        joint, sequential = (_of_group(protocols, name, FINAL) for name in ("joint", protocol))
        return subtract(joint, sequential) if joint and sequential else None
    score = protocols.get(protocol)
    value = score.metrics.get(metric.name) if score else None
    return summary(value.runs) if value and value.runs else None
