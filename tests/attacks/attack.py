"""An attack as a row of a table: how it is made, and how far it is expected to get."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .workshop import Workshop

NONE, REPLAYED, REEVALUATED, REPRODUCED = "none", "replayed", "re-evaluated", "reproduced"
LEVELS = (NONE, REPLAYED, REEVALUATED, REPRODUCED)
"""Levels with which an entry has a rank, in order. ``none`` means without a rank."""
NOT_DETECTED = "not detected"


@dataclass(frozen=True)
class Outcome:
    """How far an attack gets.

    Attributes:
        rank: the highest level with which it has a rank, one of ``LEVELS``.
        stop: what stops it there: a step and the rules that it names, or ``not detected``.
    """

    rank: str
    stop: str


@dataclass(frozen=True)
class Attack:
    """One attack.

    Attributes:
        title: what the attacker does; the row of the table.
        play: makes the attack and judges it.
        rank: the highest level with which it is expected to have a rank.
        stop: what is expected to stop it.
        evidence: the highest level whose statement is true of it. No attack may have a rank above it.
        needed: what would detect it, if nothing does.
        quick: whether ``make test`` runs it.
    """

    title: str
    play: Callable[[Workshop], Outcome]
    stop: str
    rank: str = NONE
    evidence: str = NONE
    needed: str = ""
    quick: bool = False

    @property
    def expected(self) -> Outcome:
        """The expected outcome."""
        return Outcome(self.rank, self.stop)

    @property
    def is_above_evidence(self) -> bool:
        """Whether the expected rank states more than is true."""
        return LEVELS.index(self.rank) > LEVELS.index(self.evidence)
