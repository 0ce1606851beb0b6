"""Attacks on replay that its tolerances would let pass, one test each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines.algorithms.random import Random
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.trace_reader import RecordedEpisode
from gym_extensions.scoring.replay import faults
from gym_extensions.scoring.replay.segments import replay

HOPPER = TASKS["gym_extensions/Hopper-v0"]
STRIKER = TASKS["gym_extensions/Striker-v0"]
MAP = TASKS["gym_extensions/State-Based-Navigation-2d-Map0-Goal0-v0"]


def record(task: Task) -> RecordedEpisode:
    """An honest episode of the random agent, of three segments or more."""
    seeds = list(range(4))
    env: Any = make_vec(task, len(seeds))
    agent = Random(env.single_observation_space, env.single_action_space, 0)
    rollouts = evaluate(agent, env, seeds, task.body.segments.steps)
    env.close()
    index = max(range(len(seeds)), key=lambda index: rollouts[index].length)
    rollout = rollouts[index]
    assert rollout.trace is not None and rollout.length > 2 * task.body.segments.steps
    trace = rollout.trace
    return RecordedEpisode(
        *("attack", task, seeds[index], rollout.length, rollout.terminated, rollout.success),
        *(trace.actions, trace.segment_returns, dict(trace.states)),
    )


@pytest.fixture(scope="module")
def recorded() -> Callable[[Task], RecordedEpisode]:
    """The episode of a task, recorded once. Replay finds nothing wrong with it."""
    episodes: dict[str, RecordedEpisode] = {}

    def episode(task: Task) -> RecordedEpisode:
        if task.id not in episodes:
            episodes[task.id] = record(task)
            assert replay(task, [episodes[task.id]]) == []
        return episodes[task.id]

    return episode


def refusal(episode: RecordedEpisode) -> str:
    (problem,) = replay(episode.task, [episode])
    assert problem.rule == faults.REPLAY_DIFFERS
    return problem.message


@pytest.mark.parametrize("task", [HOPPER, MAP])
def test_an_action_outside_the_action_space(recorded: Callable[[Task], RecordedEpisode], task: Task) -> None:
    """The simulator would clip it after the motor noise or the control cost has read it."""
    honest = recorded(task)
    actions = honest.actions.copy()
    actions[5] = 10.0
    message = "Steps 0 and following: a recorded action is outside the action space."
    assert refusal(replace(honest, actions=actions)) == message


def test_a_ball_that_is_a_little_struck(
    recorded: Callable[[Task], RecordedEpisode], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Any value but 0 counts as struck after the state is restored; the reward then ignores the tip."""
    honest = recorded(STRIKER)
    struck = honest.states["struck"].copy()
    assert not struck.any()
    struck[-1] = 1e-7
    attack = replace(honest, states=honest.states | {"struck": struck})
    assert "the state's 'struck' before the next segment differs by 1e-07." in refusal(attack)
    monkeypatch.setattr(faults, "EXACT_STATES", ())
    assert "'struck'" not in refusal(attack)  # only the reward of the last segment would differ


def test_a_jump_between_segments_of_navigation(recorded: Callable[[Task], RecordedEpisode]) -> None:
    """A jump of 1e-4 units, far below a millionth of the position, crosses a closed diagonal gap."""
    honest = recorded(MAP)
    positions = honest.states["position"].copy()
    positions[1:] += 1e-4
    attack = replace(honest, states=honest.states | {"position": positions})
    message = refusal(attack)
    assert message.startswith(
        "Steps 10 and following: the state's 'position' before the next segment differs by "
    )


def test_the_least_change_of_a_position_in_navigation(recorded: Callable[[Task], RecordedEpisode]) -> None:
    honest = recorded(MAP)
    positions = honest.states["position"].copy()
    positions[-1, 0] = np.nextafter(positions[-1, 0], np.inf)
    attack = replace(honest, states=honest.states | {"position": positions})
    assert "the state's 'position' before the next segment differs by " in refusal(attack)


def test_a_clock_that_is_moved(recorded: Callable[[Task], RecordedEpisode]) -> None:
    honest = recorded(HOPPER)
    time = honest.states["time"].copy()
    time[-1] += 1e-9
    assert "the state's 'time'" in refusal(replace(honest, states=honest.states | {"time": time}))
