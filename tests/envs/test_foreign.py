"""Environments of other packages as tasks: any id of Gymnasium's registry with two Boxes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.classic_control import PendulumEnv

from gym_extensions.envs import Gravity, customize, make, make_vec
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError

PENDULUM = customize("Pendulum-v1")


class Successful(PendulumEnv):
    """A pendulum that reports success."""

    def step(self, action: Any) -> Any:
        """As of the pendulum."""
        *rest, info = super().step(action)  # type: ignore[no-untyped-call]
        return *rest, info | {"is_success": True}


@pytest.fixture
def registered() -> Iterator[str]:
    """The id of an environment that a user registered."""
    make_it: Any = Successful
    gym.register("mine/Pendulum-v0", entry_point=make_it, max_episode_steps=30, kwargs={"g": 5.0})
    yield "mine/Pendulum-v0"
    del gym.registry["mine/Pendulum-v0"]


def test_it_steps_as_gymnasium_makes_it() -> None:
    ours, theirs = make("Pendulum-v1"), gym.make("Pendulum-v1")
    assert np.array_equal(ours.reset(seed=3)[0], theirs.reset(seed=3)[0])
    for _ in range(200):
        left, right = (env.step(np.array([0.5], np.float32)) for env in (ours, theirs))
        assert np.array_equal(left[0], right[0])
        assert left[1:4] == right[1:4]
    assert left[3]


def test_a_vector_environment_has_the_numbers_of_single_ones() -> None:
    env = make_vec(PENDULUM, 2)
    observations, _ = env.reset(seed=7)
    assert np.array_equal(observations[1], make(PENDULUM).reset(seed=8)[0])


def test_another_time_limit_is_another_task() -> None:
    short = customize("Pendulum-v1", max_steps=5)
    env = make(short)
    env.reset(seed=0)
    ended = [env.step(np.zeros(1, np.float32))[3] for _ in range(5)]
    assert ended == [False] * 4 + [True]
    assert fingerprint_of(short) != fingerprint_of(PENDULUM)


def test_the_fingerprint_follows_from_what_seeded_episodes_do(registered: str) -> None:
    mine = customize(registered)
    before = fingerprint_of(mine)
    fingerprint_of.cache_clear()
    assert fingerprint_of(mine) == before
    fingerprint_of.cache_clear()
    gym.registry[registered].kwargs["g"] = 9.0
    assert fingerprint_of(mine) != before
    fingerprint_of.cache_clear()


def test_a_space_that_is_no_box_is_refused() -> None:
    with pytest.raises(BenchError) as error:
        make(customize("CartPole-v1"))
    assert (error.value.code, error.value.where) == ("bad-space", "CartPole-v1")


def test_it_takes_no_variations() -> None:
    with pytest.raises(BenchError) as error:
        customize("Pendulum-v1", [Gravity(0.5)])
    assert error.value.code == "no-variation"
