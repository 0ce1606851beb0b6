"""The scorecard of a submission whose policies were evaluated on new seeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.rollouts.problem import summarize
from gym_extensions.scoring.reevaluation.record import with_returns
from gym_extensions.scoring.reevaluation.reevaluate import Reevaluation, reevaluate
from gym_extensions.scoring.scorecard.model import REPORTED, NewSeeds, Scorecard

NO_POLICIES = "It holds no policies: nothing could be re-evaluated."
SOME_POLICIES = "Not all of its logs have policies: the others were not re-evaluated."
REPLAYED = "replayed ("


def reevaluated(
    card: Scorecard, path: Path, salt: str, groups: Mapping[str, TaskGroup] = GROUPS
) -> Scorecard:
    """The scorecard with the returns on new seeds beside the logged ones, or with the problems.

    The level rises to *re-evaluated* if the submission was replayed and has the policies of all its logs. A
    submission with problems and a reported one are returned unchanged.

    Args:
        card: the scorecard of the submission, after its replay.
        path: the submission's folder.
        salt: a value that was fixed after the submission.
        groups: the groups that it may contain, by name.
    """
    if card.problems or card.trust == REPORTED:
        return card
    result = reevaluate(path, salt, groups)
    problems = tuple(summarize(result.problems, card.name))
    if problems:
        return replace(card, trust=None, problems=problems, groups={}, suites={})
    if result.p_value is None:
        return replace(card, notes=(*card.notes, NO_POLICIES))
    return replace(
        card,
        trust=_level(card.trust, result),
        groups=with_returns(card.groups, result.scores),
        notes=card.notes if result.is_complete else (*card.notes, SOME_POLICIES),
        new_seeds=NewSeeds(result.digest, result.salt, result.p_value),
    )


def _level(trust: str | None, result: Reevaluation) -> str | None:
    """The level after an evaluation of all logs; the level of the replay if some have no policies."""
    if trust is None or not result.is_complete or not trust.startswith(REPLAYED):
        return trust
    cells = f"{result.cells} cells of {EVALUATION_EPISODES} episodes on new seeds"
    return f"re-evaluated ({cells}; {trust.removeprefix(REPLAYED)}"
