"""The result of judging a submission's folder, as the limited process returns it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from gym_extensions.curation.evidence import Evidence
from gym_extensions.rollouts.problem import Problem
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.scoring.scorecard.record import Level


@dataclass(frozen=True, slots=True)
class GateScore:
    """The first metric of a submission on a group and protocol."""

    group: Annotated[str, about("group id")]
    protocol: Annotated[str, about("`sequential`, `single` or `joint`")]
    budget: Annotated[str, about("name of the budget")]
    runs: Annotated[int, about("number of runs")]
    metric: Annotated[str, about("name of the metric")]
    mean: Annotated[float | None, about("as in the scorecard")]
    low: Annotated[float | None, about("as in the scorecard")]
    high: Annotated[float | None, about("as in the scorecard")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement(JsonDocument):
    """Level of trust, problems, scores and notes."""

    level: Level | None = None
    replayed: int = 0
    episodes: int = 0
    problems: tuple[Problem, ...] = ()
    scores: tuple[GateScore, ...] = ()
    notes: tuple[str, ...] = ()


def _scores(card: Scorecard) -> tuple[GateScore, ...]:
    scores = []
    for group, protocols in card.groups.items():
        for protocol, score in protocols.items():
            metric = METRICS[protocol][0].name
            value = score.metrics[metric]
            interval = (value.mean, value.low, value.high)
            scores.append(GateScore(group, protocol, score.budget, len(score.runs), metric, *interval))
    return tuple(scores)


def judgement_of(evidence: Evidence) -> Judgement:
    """The result of a proof."""
    return Judgement(
        level=evidence.level,
        replayed=evidence.replayed,
        episodes=evidence.episodes,
        problems=evidence.problems,
        scores=() if evidence.problems else _scores(evidence.card),
        notes=(*evidence.card.notes, *evidence.card.signs),
    )
