"""A metric of a scorecard as a mean with its error: of one group, or of several groups together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gym_extensions.scoring.metrics.definitions import FINAL, JOINT_GAP, Metric
from gym_extensions.scoring.statistics.intervals import Summary, mean_of_groups, subtract, summary


def estimate(
    groups: Mapping[str, Any], names: Sequence[str], protocol: str, metric: Metric
) -> Summary | None:
    """The mean over the named groups of a metric's mean over runs; None where it has no value in one of them.

    Args:
        groups: the ``groups`` of a scorecard.
        names: ids of independent groups.
        protocol: sequential, single or joint.
        metric: one of that protocol.
    """
    parts = [_of_group(groups.get(name, {}), protocol, metric) for name in names]
    whole = [part for part in parts if part is not None]
    if not whole or len(whole) < len(parts):
        return None
    return whole[0] if len(whole) == 1 else mean_of_groups(whole)


def _of_group(protocols: Mapping[str, Any], protocol: str, metric: Metric) -> Summary | None:
    if metric is JOINT_GAP:  # no function of one run: joint and sequential runs are not pairs
        joint, own = (_of_group(protocols, name, FINAL) for name in ("joint", protocol))
        return subtract(joint, own) if joint and own else None
    values = protocols.get(protocol, {}).get("metrics", {}).get(metric.name, {}).get("runs", [])
    return summary(values) if values else None
