"""Environments without a state, and closed ones, raise errors instead of stopping the process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions import envs
from gym_extensions.catalog.registry import task
from gym_extensions.envs.make import construct
from gym_extensions.errors import BenchError

NAMES = [
    "Hopper",
    "Humanoid",
    "Pusher",
    "State-Based-Navigation-2d-Map0-Goal0",
    "State-Based-Navigation-2d-Map0-Goal0-KnownGoalPosition",
    "Limited-Range-Based-Navigation-2d-Map0-Goal0",
    "Limited-Range-Based-Navigation-2d-Map0-Goal0-KnownPositions",
    "Image-Based-Navigation-2d-Map0-Goal0",
]
UNSET = "{}: The environment has no state before its first reset. Call reset() first."
MASK = {"reset_mask": np.array([True, False])}


def saved(name: str) -> dict[str, Any]:
    """The states of two environments."""
    env: Any = envs.make_vec(name, 2)
    env.reset(seed=0)
    states: dict[str, Any] = env.save_states()
    return states


VECTOR: dict[str, Callable[[Any, str], object]] = {
    "step": lambda env, _: env.step(np.zeros(env.action_space.shape, np.float32)),
    "save_states": lambda env, _: env.save_states(),
    "call save_state": lambda env, _: env.call("save_state"),
    "reset of some environments": lambda env, _: env.reset(options=MASK),
    "restore of some environments": lambda env, name: env.restore_states(
        {key: rows[:1] for key, rows in saved(name).items()}, [1]
    ),
}


@pytest.mark.parametrize("name", NAMES)
def test_a_vector_environment_needs_a_reset_first(name: str) -> None:
    env = envs.make_vec(name, 2)
    for use in VECTOR.values():
        with pytest.raises(gym.error.ResetNeeded) as caught:
            use(env, name)
        assert isinstance(caught.value, BenchError)
        assert str(caught.value) == UNSET.format("make_vec")
    env.reset(seed=0)
    for use in VECTOR.values():
        use(env, name)


@pytest.mark.parametrize("name", NAMES)
def test_a_restore_of_all_environments_replaces_the_reset(name: str) -> None:
    env: Any = envs.make_vec(name, 2)
    env.restore_states(saved(name))
    env.step(np.zeros(env.action_space.shape, np.float32))


@pytest.mark.parametrize("name", NAMES)
def test_an_environment_needs_a_reset_first(name: str) -> None:
    env: Any = construct(name, render_mode="rgb_array") if "Navigation" in name else construct(name)
    uses: list[Callable[[], object]] = [lambda: env.step(env.action_space.sample()), env.save_state]
    if "Navigation" in name:
        uses.append(env.render)
    for use in uses:
        with pytest.raises(gym.error.ResetNeeded) as caught:
            use()
        assert str(caught.value) == UNSET.format(task(name).id)
    env.restore_state({key: rows[0] for key, rows in saved(name).items()})
    for use in uses:
        use()


@pytest.mark.parametrize("name", NAMES)
def test_a_closed_vector_environment_raises_an_error(name: str) -> None:
    env: Any = envs.make_vec(name, 2)
    env.reset(seed=0)
    env.close()
    env.close()
    uses: list[Callable[[Any, str], object]] = [*VECTOR.values(), lambda env, _: env.reset()]
    for use in uses:
        with pytest.raises(gym.error.ClosedEnvironmentError) as caught:
            use(env, name)
        assert str(caught.value) == "make_vec: The environment is closed. Make a new one."


@pytest.mark.parametrize("name", NAMES[3:])
def test_a_refused_start_or_restore_changes_nothing(name: str) -> None:
    env, single = envs.make_vec(name, 2), construct(name)
    vector: Any = env
    for first in ({}, {"seed": 0}):  # before any reset, then in mid-episode
        if first:
            env.reset(seed=0)
            single.reset(seed=0)
            before = vector.save_states()
        for each in (env, single):
            with pytest.raises(BenchError, match="The start"):
                each.reset(seed=3, options={"start": (5.0, 5.0)})
        states = saved(name)
        for bad in (np.full((2, 2), 5.0), np.array([states["position"][0], [np.nan, 5.0]])):
            with pytest.raises(BenchError):
                vector.restore_states(states | {"position": bad})
        if not first:
            with pytest.raises(gym.error.ResetNeeded):
                env.step(np.zeros((2, 2)))
            with pytest.raises(gym.error.ResetNeeded):
                single.step(np.zeros(2))
            continue
        assert all(np.array_equal(before[key], rows) for key, rows in vector.save_states().items())
        env.step(np.zeros((2, 2)))
        single.step(np.zeros(2))


@pytest.mark.parametrize("steps", [-1.0, 0.5, 1e300])
def test_a_saved_count_of_steps_is_a_whole_number(steps: float) -> None:
    name = NAMES[3]
    env: Any = envs.make_vec(name, 2)
    states = saved(name) | {"steps": np.array([0.0, steps])}
    with pytest.raises(BenchError) as caught:
        env.restore_states(states)
    hint = "It is a whole number of at least 0."
    assert str(caught.value) == f"{task(name).id}: The state's 'steps' is {steps:g}. {hint}"
