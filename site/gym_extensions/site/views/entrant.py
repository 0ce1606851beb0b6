"""What pages of many entries show of one: its scorecard without success rates and training curves."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gym_extensions.scoring.scorecard.model import Scorecard

SEQUENTIAL = "sequential"


@dataclass(frozen=True)
class Entrant:
    """An entry without the long parts of its logs, so that many fit in memory.

    Args:
        card: the scorecard without success rates, training curves and README.
        inputs: the digest of the whole scorecard.
    """

    card: Scorecard
    inputs: bytes = b""


def entrant(card: Scorecard, inputs: bytes = b"") -> Entrant:
    """The part of a scorecard that pages of many entries show."""
    groups = {
        group: {protocol: replace(score, success_rates=(), curves=()) for protocol, score in scores.items()}
        for group, scores in card.groups.items()
    }
    return Entrant(replace(card, readme="", groups=groups), inputs)
