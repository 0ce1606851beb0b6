"""What pages of many entries show of one: its scorecard without logs, and its retention per group."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from gym_extensions.scoring.scorecard.model import GroupScore, Scorecard
from gym_extensions.site.views.profile import whole_profile
from gym_extensions.site.views.retention import Retention, retention

SEQUENTIAL = "sequential"


@dataclass(frozen=True)
class Entrant:
    """An entry without its logs, so that many fit in memory.

    Args:
        card: the scorecard without returns, curves and README.
        retention: by group id, of the sequential logs.
    """

    card: Scorecard
    retention: Mapping[str, Retention]


def entrant(card: Scorecard) -> Entrant:
    """The part of a scorecard that pages of many entries show."""
    groups = {
        group: {protocol: _without_logs(score) for protocol, score in scores.items()}
        for group, scores in card.groups.items()
    }
    kept = {
        group: retention(scores[SEQUENTIAL]) for group, scores in card.groups.items() if SEQUENTIAL in scores
    }
    return Entrant(replace(card, readme="", groups=groups), kept)


def _without_logs(score: GroupScore) -> GroupScore:
    profile = whole_profile(score)
    return replace(score, profile=profile, return_matrix=(), success_rates=(), curves=())
