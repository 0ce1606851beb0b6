"""Environments of other packages as tasks: any id of Gymnasium's registry with two Boxes."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.classic_control import PendulumEnv

from gym_extensions.envs import Gravity, TaskGroup, customize, foreign, make, make_vec
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError

from ..conftest import refused

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


def test_an_id_without_a_registered_limit_takes_that_of_the_task() -> None:
    make_it: Any = PendulumEnv
    gym.register("mine/Endless-v0", entry_point=make_it)
    try:
        with pytest.raises(BenchError, match="mine/Endless-v0 has no time limit"):
            customize("mine/Endless-v0")
        assert customize("mine/Endless-v0", max_steps=5).max_steps == 5
    finally:
        del gym.registry["mine/Endless-v0"]


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
    with refused("bad-space", where="CartPole-v1"):
        make(customize("CartPole-v1"))


def test_it_takes_no_variations() -> None:
    with refused("no-variation"):
        customize("Pendulum-v1", [Gravity(0.5)])


class Odd(gym.Env[Any, Any]):
    """An environment as people write them: no ``render_mode``, lists, rewards (1,), an own generator."""

    observation_space = gym.spaces.Box(-1, 1, (2,), np.float32)
    action_space = gym.spaces.Box(-1, 1, (1,), np.float32)
    metadata = {"render_modes": []}  # noqa: RUF012

    def __init__(self) -> None:
        self.rng = np.random.RandomState(0)

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        self.rng, self.steps = np.random.RandomState(seed), 0
        return self.seen(), {}

    def seen(self) -> Any:
        return self.rng.uniform(-1, 1, 2).tolist()

    def step(self, action: Any) -> Any:
        self.steps += 1
        return self.seen(), self.reward(action), np.array([self.steps >= 1500]), 0, {}

    def reward(self, action: Any) -> Any:
        return np.asarray(action)


class Unseeded(Odd):
    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        return super().reset(seed=None)


class SeededWhenMade(Odd):
    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        self.steps = 0
        return self.seen(), {}


class GlobalGenerator(Odd):
    def reward(self, action: Any) -> Any:
        return np.random.normal() if self.steps == 100 else 0.0  # noqa: NPY002


class Outside(Odd):
    def seen(self) -> Any:
        return [1.5, 0.0] if getattr(self, "steps", 0) == 3 else [1.0 + 1e-7, 0.0]


class WrongShape(Odd):
    def seen(self) -> Any:
        return [0.0]


class FourValues(Odd):
    def step(self, action: Any) -> Any:
        return self.seen(), 0.0, False, {}


class OldReset(Odd):
    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        return self.seen()


class NoInfo(Odd):
    def step(self, action: Any) -> Any:
        return *super().step(action)[:4], None


class Raises(Odd):
    def reward(self, action: Any) -> Any:
        raise ZeroDivisionError("division by zero")


class Text(Odd):
    def reward(self, action: Any) -> Any:
        return "much"


class LateNan(Odd):
    def reward(self, action: Any) -> Any:
        return float("nan") if self.steps == 1000 else 0.0


class NotMade(Odd):
    def __init__(self) -> None:
        raise FileNotFoundError("model.xml")


@pytest.fixture
def task_of() -> Iterator[Callable[[Any], Any]]:
    """The task of a class of environments."""
    before = dict(gym.registry)

    def task(kind: Any) -> Any:
        gym.register(f"mine/{kind.__name__}-v0", entry_point=kind, max_episode_steps=2000)
        return customize(f"mine/{kind.__name__}-v0")

    yield task
    gym.registry.clear()
    gym.registry.update(before)


def test_what_an_environment_returns_is_made_regular(task_of: Callable[[Any], Any]) -> None:
    task = task_of(Odd)
    foreign.check(TaskGroup("mine", (task,)))
    env = make(task)
    assert env.reset(seed=0)[0].dtype == np.float32
    observation, reward, terminated, truncated, _ = env.step(np.array([0.25], np.float32))
    assert observation.shape == (2,)
    assert (reward, terminated, truncated) == (0.25, False, False)
    several = make_vec(task, 2)
    several.reset(seed=0)
    assert several.step(np.full((2, 1), 0.25, np.float32))[1].tolist() == [0.25, 0.25]


BROKEN: list[tuple[type[Odd], str]] = [
    (Unseeded, "differ at step 0. Call super().reset(seed=seed), and draw every random number from"),
    (SeededWhenMade, "differ at step 0."),
    (GlobalGenerator, "two episodes with the seed 0 and the same actions differ at step 100."),
    (Outside, "the observation at step 3 lies outside of Box("),
    (WrongShape, "reset() returned the observation of shape (1,); expected (2,)."),
    (FourValues, "(expected 5, got 4)"),
    (Raises, "step 1 of an episode, with the action ["),
    (OldReset, "reset() returned list; expected 2 values"),
    (NoInfo, "returned the info None; expected a dictionary"),
    (Raises, "raised ZeroDivisionError: division by zero."),
    (Text, "returned the reward array(['much']"),
    (NotMade, "It cannot be made: FileNotFoundError: model.xml."),
]


@pytest.mark.parametrize(("kind", "fact"), BROKEN)
def test_a_broken_environment_is_named_before_training(
    kind: type[Odd], fact: str, task_of: Callable[[Any], Any]
) -> None:
    task = task_of(kind)
    with pytest.raises(BenchError) as error:
        foreign.check(TaskGroup("mine", (task,)))
    assert (error.value.code, error.value.where) == ("bad-environment", f"mine/{kind.__name__}-v0")
    assert fact in str(error.value)
    assert "agent" not in str(error.value)


def test_nan_in_the_thousandth_step_is_named_with_the_step_the_task_and_the_action(
    task_of: Callable[[Any], Any],
) -> None:
    task = task_of(LateNan)
    foreign.check(TaskGroup("mine", (task,)))
    env = make(task)
    env.reset(seed=0)
    with pytest.raises(BenchError) as error:
        for _ in range(1000):
            env.step(np.array([0.5], np.float32))
    assert str(error.value) == (
        "mine/LateNan-v0: The environment mine/LateNan-v0 is broken: step 1000 of an episode, with the "
        "action [0.5], returned the reward nan. "
        "Correct the environment, or register it with a wrapper that does."
    )


class Slow(Odd):
    def reward(self, action: Any) -> Any:
        time.sleep(0.05)
        return 0.0


def test_the_check_of_a_group_of_slow_environments_takes_less_than_two_seconds(
    task_of: Callable[[Any], Any],
) -> None:
    slow = task_of(Slow)
    tasks = tuple(customize(slow, max_steps=steps) for steps in (500, 600, 700, 800))
    start = time.monotonic()
    foreign.check(TaskGroup("mine", tasks))
    assert time.monotonic() - start < 2
