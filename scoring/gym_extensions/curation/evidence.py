"""What a submission's folder proves: its level of trust, measured by replay. Loads a simulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.rollouts.problem import Problem, summarize
from gym_extensions.scoring.pipeline.score import make_scorer
from gym_extensions.scoring.repetition.scorecard import is_repeated
from gym_extensions.scoring.scorecard.model import REPORTED, Scorecard
from gym_extensions.scoring.scorecard.record import Level


@dataclass(frozen=True)
class Evidence:
    """The scorecard of a submission, its level of trust (None with problems), and the replayed episodes.

    All episodes are replayed if the repository has the record of their repetition.
    """

    card: Scorecard
    level: Level | None
    replayed: int
    episodes: int
    problems: tuple[Problem, ...]


def prove(path: Path, salt: str = "", groups: Mapping[str, TaskGroup] = GROUPS) -> Evidence:
    """Scores a submission, replays its audit sample, and looks for the record of its repetition.

    Args:
        path: the submission's folder.
        salt: must have selected the sample, 64 hexadecimal digits; empty for the sample without a salt.
        groups: the groups that it may contain, by name.

    Raises:
        BenchError: another version of MuJoCo or Gymnasium is installed than the published one, or the record
            cannot be read.
    """
    from gym_extensions.scoring.replay.verify import verify  # loads a simulator

    card = make_scorer()(path)
    if card.problems:
        return Evidence(card, None, 0, 0, card.problems)
    if card.trust == REPORTED:
        return Evidence(card, "reported", 0, 0, ())
    verification = verify(path, groups, salt)
    if verification.problems:
        problems = summarize(verification.problems, card.name)
        return Evidence(card, None, 0, verification.episodes, problems)
    sampled = 0 if verification.is_partial else verification.replayed
    replayed = verification.episodes if is_repeated(path, groups) else sampled
    level: Level = "replayed" if replayed else "validated"
    return Evidence(card, level, replayed, verification.episodes, ())
