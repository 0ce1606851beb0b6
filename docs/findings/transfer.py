"""Whether earlier tasks help: the transfers of fine-tuning on a group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gym_extensions.scoring.metrics import BY_NAME
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.statistics import Interval

TRANSFERS = (
    "zero_shot_transfer",
    "generalization_to_unseen_tasks",
    "asymptotic_transfer",
    "forward_transfer_auc",
    "joint_gap",
    "practice",
    "transfer_at_equal_practice",
)
TITLES = [BY_NAME[name].title for name in TRANSFERS]


@dataclass(frozen=True)
class Transfer:
    """The metrics of ``TRANSFERS`` on a group, with None where one has no value."""

    group: str
    values: tuple[Interval | None, ...]


def transfer(card: Scorecard, group_id: str, name: str) -> Transfer:
    """The transfers of an entry on a group that it was trained on in order."""
    metrics = card.groups[group_id]["sequential"].metrics
    present = [metrics[metric] for metric in TRANSFERS]
    return Transfer(
        name,
        tuple(None if each.mean is None else Interval(each.mean, each.low, each.high) for each in present),
    )


def shown(rows: Sequence[Transfer]) -> list[Transfer]:
    """The groups with a value, those with most values first."""
    present = [row for row in rows if any(row.values)]
    return sorted(present, key=lambda row: sum(value is None for value in row.values))
