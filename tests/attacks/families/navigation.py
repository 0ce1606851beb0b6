"""Attacks on replay of navigation, whose tolerance is zero, and on what its logs may say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.trace_reader import RecordedEpisode
from gym_extensions.scoring.pipeline.score import score_folder
from gym_extensions.scoring.replay.segments import replay

from ...conftest import write_submission
from ...scoring.replay.test_attacks import MAP, record
from ..attack import NONE, NOT_DETECTED, Attack, Outcome
from ..judge import REFERENCES
from ..workshop import Workshop

OTHER_MAP = TASKS["gym_extensions/State-Based-Navigation-2d-Map1-Goal0-v0"]
Arrays = dict[str, np.ndarray[Any, Any]]


@cache
def honest(task: Task) -> RecordedEpisode:
    """An honest episode of the random agent."""
    return record(task)


def episode(edit: Callable[[RecordedEpisode], RecordedEpisode]) -> Callable[[Workshop], Outcome]:
    """Judges an episode by replay."""

    def play(workshop: Workshop) -> Outcome:
        forged = edit(honest(MAP))
        rules = sorted({problem.rule for problem in replay(forged.task, [forged])})
        return Outcome(NONE, f"replay: {', '.join(rules)}" if rules else NOT_DETECTED)

    return play


def states(name: str, edit: Callable[[np.ndarray[Any, Any]], object]) -> Callable[[Workshop], Outcome]:
    """Judges an episode with another state at the seams."""

    def change(forged: RecordedEpisode) -> RecordedEpisode:
        values = forged.states[name].copy()
        edit(values)
        return replace(forged, states=forged.states | {name: values})

    return episode(change)


def row(**cells: str) -> Callable[[Workshop], Outcome]:
    """Judges a log whose first row has other cells."""

    def play(workshop: Workshop) -> Outcome:
        folder = write_submission(
            workshop.empty(),
            groups=("nav-state",),
            runs=(0,),
            protocols=("single",),
            value=lambda *_: -1000.0,
        )
        path = folder / "nav-state" / "single.csv"
        header, first, *others = path.read_text().splitlines()
        values = dict(zip(header.split(","), first.split(","), strict=True)) | cells
        path.write_text("\n".join([header, ",".join(values.values()), *others, ""]), newline="\n")
        rules = sorted({problem.rule for problem in score_folder(folder, REFERENCES).problems})
        return Outcome(NONE, f"rules: {', '.join(rules)}" if rules else NOT_DETECTED)

    return play


def jump(values: np.ndarray[Any, Any]) -> None:
    values[1:] += 1e-4


def least(values: np.ndarray[Any, Any]) -> None:
    values[-1, 0] = np.nextafter(values[-1, 0], np.inf)


def elsewhere(values: np.ndarray[Any, Any]) -> None:
    values[0] += 50.0


def fewer_steps(values: np.ndarray[Any, Any]) -> None:
    values[-1] -= 1


def without_collisions(forged: RecordedEpisode) -> RecordedEpisode:
    """States the reward of a segment as if nothing had been hit."""
    returns = np.full_like(forged.returns, -10.0)
    returns[0] += 1.0
    return replace(forged, returns=returns)


def long_actions(forged: RecordedEpisode) -> RecordedEpisode:
    actions = forged.actions.copy()
    actions[5] *= 100.0
    actions[5] += 100.0
    return replace(forged, actions=actions)


def at_goal(forged: RecordedEpisode) -> RecordedEpisode:
    return replace(forged, terminated=True, success=True)


DIFFERS = "replay: replay-differs"
ATTACKS = (
    Attack(
        "A jump of 1e-4 units at a seam, which crosses a closed diagonal gap.",
        states("position", jump),
        DIFFERS,
    ),
    Attack("The least change of a position at a seam.", states("position", least), DIFFERS),
    Attack("The first seam is 50 units nearer to the goal.", states("position", elsewhere), DIFFERS),
    Attack("An action is beyond the largest step.", episode(long_actions), DIFFERS),
    Attack("Rewards are those of an episode without collisions.", episode(without_collisions), DIFFERS),
    Attack("The goal is said to be reached.", episode(at_goal), DIFFERS),
    Attack(
        "The episode is from another start.",
        episode(lambda forged: replace(forged, seed=forged.seed + 1)),
        DIFFERS,
    ),
    Attack(
        "The episode is from another map.", episode(lambda forged: replace(forged, task=OTHER_MAP)), DIFFERS
    ),
    Attack(
        "The log claims success without an arrival.",
        row(success="true"),
        "rules: contradictory-success",
    ),
    Attack(
        "The log claims more than a straight way can give.",
        row(length="5", terminated="true", success="true", **{"return": "11.0"}),
        "rules: impossible-return",
    ),
)
