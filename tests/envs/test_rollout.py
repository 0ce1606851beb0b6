"""The loop that runs a policy on given seeds."""

import math
from typing import Any, Self

import numpy as np
import pytest

from gym_extensions.envs import make, make_vec
from gym_extensions.envs.rollout import Outcome, clip_actions, run_episodes

from ..conftest import refused


def action_of(observation: Any, size: int) -> Any:
    """Some deterministic policy, which leaves the action space at times."""
    return 2.0 * np.sin(3.0 * np.resize(observation, size))


@pytest.mark.parametrize("task", ["Hopper", "Pusher", "State-Based-Navigation-2d-Map0-Goal0"])
def test_outcomes_are_those_of_single_environments(task: str) -> None:
    seeds = [3, 1000, 4]
    env = make_vec(task, len(seeds))
    size = env.single_action_space.shape[0]  # type: ignore[index]
    outcomes = run_episodes(env, seeds, lambda rows, *_: np.stack([action_of(row, size) for row in rows]))
    for seed, outcome in zip(seeds, outcomes, strict=True):
        single: Any = make(task)
        observation, _ = single.reset(seed=seed)
        rewards, terminated, truncated, info = [], False, False, {}
        while not terminated and not truncated:
            action = np.clip(action_of(observation, size), single.action_space.low, single.action_space.high)
            observation, reward, terminated, truncated, info = single.step(action.astype(np.float32))
            rewards.append(reward)
        expected = Outcome(len(rewards), math.fsum(rewards), bool(terminated), info.get("is_success"))
        assert outcome == expected


def test_the_policy_is_told_which_observations_start_an_episode_and_which_episodes_run() -> None:
    env = make_vec("Hopper", 2)
    calls: list[tuple[Any, Any]] = []
    applied: list[Any] = []

    def act(rows: Any, starts: Any, running: Any) -> Any:
        calls.append((starts, running))
        return np.full((2, 3), [[1.0], [-1.0]])

    first = run_episodes(env, [0, 1], act, watch=applied.append)
    short = min(range(2), key=lambda index: first[index].length)
    length = first[short].length
    assert calls[0][0].all() and not calls[1][0].any()
    assert calls[length + 1][0].tolist() == [index == short for index in range(2)]
    assert [bool(running[short]) for _, running in calls].index(False) == length
    assert len(calls) == max(outcome.length for outcome in first) == len(applied) - 1
    assert applied[0] is None and applied[1].dtype == np.float32


@pytest.mark.parametrize("actions", [np.zeros((2, 2)), np.full((2, 3), np.nan), [["a"]], None])
def test_actions_are_checked(actions: Any) -> None:
    with refused("bad-actions"):
        run_episodes(make_vec("Hopper", 2), [0, 1], lambda *_: actions)


def test_only_running_episodes_need_finite_actions() -> None:
    def act(rows: Any, starts: Any, running: Any) -> Any:
        return np.where(running[:, None], [[1.0], [-1.0]], np.nan) * np.ones((2, 3))

    first = run_episodes(make_vec("Hopper", 2), [0, 1], act)
    again = run_episodes(make_vec("Hopper", 2), [0, 1], lambda *_: np.full((2, 3), [[1.0], [-1.0]]))
    assert first == again and first[0].length != first[1].length


class OnAnotherDevice:
    """What a tensor on a GPU is to numpy: no array, but one after ``detach().cpu()``."""

    def __init__(self, values: object) -> None:
        self.values = values

    def detach(self) -> Self:
        return self

    def cpu(self) -> object:
        return self.values

    def __array__(self) -> object:
        raise TypeError("can't convert cuda:0 device type tensor to numpy")


def test_actions_may_be_a_tensor_on_another_device() -> None:
    actions = clip_actions(OnAnotherDevice(np.full((2, 3), 9.0)), make_vec("Hopper", 2), "act()")
    assert actions.tolist() == [[1.0] * 3] * 2
