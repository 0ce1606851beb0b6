"""Environments of other packages as tasks: any id of Gymnasium's registry with two Boxes."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.classic_control import PendulumEnv

from gym_extensions.envs import Gravity, customize, foreign, make, make_vec
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError

from ..conftest import refused

PENDULUM = customize("Pendulum-v1")


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
    assert customize(PENDULUM, max_steps=5) == short


@pytest.fixture
def task_of() -> Iterator[Callable[..., Any]]:
    """Registers a class of environments, and gives its task."""
    before = dict(gym.registry)

    def task(kind: Any, **registered: Any) -> Any:
        gym.register(f"mine/{kind.__name__}-v0", entry_point=kind, **registered)
        return customize(f"mine/{kind.__name__}-v0")

    yield task
    gym.registry.clear()
    gym.registry.update(before)


def test_an_id_without_a_registered_limit_takes_that_of_the_task(task_of: Callable[..., Any]) -> None:
    with pytest.raises(BenchError, match="mine/PendulumEnv-v0 has no time limit"):
        task_of(PendulumEnv)
    assert customize("mine/PendulumEnv-v0", max_steps=5).max_steps == 5


def test_the_fingerprint_follows_from_what_seeded_episodes_do(task_of: Callable[..., Any]) -> None:
    mine = task_of(PendulumEnv, max_episode_steps=30, kwargs={"g": 5.0})
    before = fingerprint_of(mine)
    fingerprint_of.cache_clear()
    assert fingerprint_of(mine) == before
    fingerprint_of.cache_clear()
    gym.registry[mine.id].kwargs["g"] = 9.0
    assert fingerprint_of(mine) != before
    fingerprint_of.cache_clear()


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


def test_a_vector_environment_makes_as_many_as_it_has_and_closes_them(task_of: Callable[..., Any]) -> None:
    alive: list[object] = []

    class Counted(Odd):
        def __init__(self) -> None:
            alive.append(self)

        def close(self) -> None:
            alive.remove(self)

    task = task_of(Counted, max_episode_steps=5)
    several = make_vec([task, customize(task, max_steps=3)], 3)
    assert len(alive) == 3
    several.close()
    with refused("different-spaces"):
        make_vec([task, PENDULUM], 2)
    assert not alive


@pytest.mark.parametrize(
    ("name", "space"),
    [
        ("action_space", gym.spaces.Discrete(3)),
        ("action_space", gym.spaces.Box(0, np.inf, (1,), np.float32)),
        ("action_space", gym.spaces.Box(np.array([0, 1], np.float32), np.ones(2, np.float32))),
        ("action_space", gym.spaces.Box(-1, 1, (2, 2), np.float32)),
        ("action_space", gym.spaces.Box(-1, 1, (), np.float32)),
        ("action_space", gym.spaces.Box(-3, 3, (2,), np.int64)),
        ("observation_space", gym.spaces.Box(-1, 1, (), np.float32)),
        ("observation_space", gym.spaces.Dict()),
    ],
)
def test_spaces_that_policies_do_not_support_are_refused(
    name: str, space: Any, task_of: Callable[..., Any]
) -> None:
    with refused("bad-space", f"Its {name} is {space}. Wrap it: both are a Box"):
        make(task_of(type("Other", (Odd,), {name: space}), max_episode_steps=5))


def test_what_an_environment_returns_is_made_regular(task_of: Callable[..., Any]) -> None:
    task = task_of(Odd, max_episode_steps=2000)
    foreign.check([task])
    env = make(task)
    assert env.reset(seed=0)[0].dtype == np.float32
    observation, reward, terminated, truncated, _ = env.step(np.array([0.25], np.float32))
    assert observation.shape == (2,)
    assert (reward, terminated, truncated) == (0.25, False, False)
    several = make_vec(task, 2)
    several.reset(seed=0)
    assert several.step(np.full((2, 1), 0.25, np.float32))[1].tolist() == [0.25, 0.25]


def own_array(self: Any) -> Any:
    """One array for all observations, as in many environments, which is 0 after every 200 steps."""
    self.array = getattr(self, "array", np.zeros(2, np.float32))
    self.array[:] = self.rng.uniform(-1, 1, 2) if self.steps % 200 else 0
    return self.array


def test_an_observation_does_not_change_in_later_steps(task_of: Callable[..., Any]) -> None:
    task = task_of(type("OwnArray", (Odd,), {"seen": own_array}), max_episode_steps=2000)
    foreign.check([task])
    env = make(task)
    first, _ = env.reset(seed=0)
    env.step(np.zeros(1, np.float32))
    assert first.tolist() == [0, 0]


def raises(error: Exception) -> Any:
    """A method that raises it."""

    def method(self: Any, *arguments: Any) -> Any:
        raise error

    return method


BYTES = {"observation_space": gym.spaces.Box(0, 255, (2,), np.uint8)}
BROKEN: dict[str, tuple[dict[str, Any], str]] = {
    "Unseeded": (
        {"reset": lambda self, **_: Odd.reset(self)},
        "differ at step 0. Call super().reset(seed=seed), and draw every random number from",
    ),
    "UnseededOwnArray": (
        {"seen": own_array, "reset": lambda self, **_: Odd.reset(self)},
        "differ at step 1.",
    ),
    "SeededWhenMade": ({"steps": 0, "reset": lambda self, **_: (self.seen(), {})}, "differ at step 0."),
    "DrawnWhenMade": (
        {
            "__init__": lambda self: setattr(self, "offset", np.random.uniform()),  # noqa: NPY002
            "reward": lambda self, _: self.offset,
        },
        "differ at step 1.",
    ),
    "GlobalGenerator": (
        {"reward": lambda self, _: np.random.normal() if self.steps == 100 else 0.0},  # noqa: NPY002
        "two episodes with the seed 0 and the same actions differ at step 100.",
    ),
    "Outside": (
        {"seen": lambda self: [1.5 if self.steps == 3 else 1.0 + 1e-7, 0.0]},
        "the observation at step 3 lies outside of Box(",
    ),
    "WrongShape": ({"seen": lambda _: [0.0]}, "returned the observation of shape (1,); expected (2,)."),
    "Fractions": (BYTES | {"seen": lambda _: [0.0, 0.3]}, "[0.0, 0.3], which is not made of uint8 numbers."),
    "Negative": (BYTES | {"seen": lambda _: np.array([300, -1])}, "which is not made of uint8 numbers."),
    "TooLarge": (BYTES | {"seen": lambda _: [300, 0]}, "which is not made of uint8 numbers."),
    "FourValues": ({"step": lambda self, _: (self.seen(), 0.0, False, {})}, "(expected 5, got 4)"),
    "OldReset": ({"reset": lambda self, **_: self.seen()}, "reset() returned list; expected 2 values"),
    "NoInfo": (
        {"step": lambda self, action: (*Odd.step(self, action)[:4], None)},
        "returned the info None; expected a dictionary",
    ),
    "Raises": ({"reward": raises(ZeroDivisionError("by zero"))}, "raised ZeroDivisionError: by zero."),
    "RaisesLater": ({"reward": raises(ValueError())}, "step 1 of an episode, with the action ["),
    "Text": ({"reward": lambda self, _: "much"}, "returned the reward array(['much']"),
    "NotMade": ({"__init__": raises(FileNotFoundError("a"))}, "It cannot be made: FileNotFoundError: a."),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_environment_is_named_before_training(name: str, task_of: Callable[..., Any]) -> None:
    methods, fact = BROKEN[name]
    task = task_of(type(name, (Odd,), methods), max_episode_steps=2000)
    with refused("bad-environment", fact, where=f"mine/{name}-v0"):
        foreign.check([task])


def test_nan_in_the_thousandth_step_is_named_with_step_task_and_action(task_of: Callable[..., Any]) -> None:
    late = {"reward": lambda self, _: float("nan") if self.steps == 1000 else 0.0}
    task = task_of(type("LateNan", (Odd,), late), max_episode_steps=2000)
    foreign.check([task])
    env = make(task)
    env.reset(seed=0)
    with refused("bad-environment", "step 1000 of an episode", "action [0.5]", "the reward nan"):
        for _ in range(1000):
            env.step(np.array([0.5], np.float32))


def test_the_check_of_four_slow_environments_takes_less_than_two_seconds(task_of: Callable[..., Any]) -> None:
    def reward(*_: Any) -> float:
        time.sleep(0.05)
        return 0.0

    slow = task_of(type("Slow", (Odd,), {"reward": reward}), max_episode_steps=2000)
    tasks = tuple(customize(slow, max_steps=steps) for steps in (500, 600, 700, 800))
    start = time.monotonic()
    foreign.check(tasks)
    assert time.monotonic() - start < 2
