"""Vector environments equal the single environments bit for bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions import envs
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.catalog.variations.base import RuntimeVariation
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart, TrackingGoal
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise, Wall
from gym_extensions.envs.batch.seeding import spawn_seeds

STEPS = 1000
SEED, SCALE = 5, 1.2


def assert_bitwise_equal(
    tasks: Sequence[str | Task], num_envs: int, steps: int, dtype: type = np.float32
) -> None:
    """Steps a vector environment and single environments and compares every number."""
    vector: Any = envs.make_vec(tasks, num_envs)
    singles: list[Any] = [envs.make(tasks[index % len(tasks)]) for index in range(num_envs)]
    seeds = spawn_seeds(SEED, num_envs)
    observations, _ = vector.reset(seed=SEED)
    firsts = [env.reset(seed=seed)[0] for env, seed in zip(singles, seeds, strict=True)]
    assert np.array_equal(observations, firsts)
    generator = np.random.default_rng(SEED)
    space = vector.single_action_space
    assert isinstance(space, gym.spaces.Box)
    ended = [False] * num_envs
    for step in range(steps):
        drawn = generator.uniform(SCALE * space.low, SCALE * space.high, (num_envs, *space.shape))
        actions: Any = drawn.astype(dtype)
        result = vector.step(actions)
        for index, env in enumerate(singles):
            expected = (env.reset()[0], 0.0, False, False) if ended[index] else env.step(actions[index])[:4]
            ended[index] = bool(expected[2] or expected[3])
            for part, single in zip(result[:4], expected, strict=True):
                assert np.array_equal(part[index], single), (step, index)
        if step % 100 == 7 or step == steps - 1:
            for saved, env in zip(vector.call("save_state"), singles, strict=True):
                expected_state = env.unwrapped.save_state()
                assert saved.keys() == expected_state.keys()
                assert all(np.array_equal(saved[name], expected_state[name]) for name in saved)
    assert result[0].dtype == observations.dtype == vector.single_observation_space.dtype
    vector.close()


def side_by_side() -> dict[str, list[str]]:
    """Every published task, grouped by equal spaces."""
    kinds: dict[str, list[str]] = {}
    for row in TASKS.values():
        sensor = any(isinstance(variation, RangeSensor) for variation in row.variations)
        kind = f"{row.base} with sensor" if sensor else row.base
        if row.base != "Navigation":
            kinds.setdefault(kind, []).append(row.id)
    return kinds


KINDS = side_by_side()


@pytest.mark.parametrize("kind", KINDS)
def test_every_published_task(kind: str) -> None:
    assert_bitwise_equal(KINDS[kind], num_envs=len(KINDS[kind]), steps=STEPS + 10)


CUSTOM: dict[str, list[Task]] = {
    "everything at once on one body": [
        Task(
            "HopperBusy",
            "Hopper",
            (Gravity(0.7), LimbScale("Foot", 1.2), RangeSensor(), Wall(), SensorNoise(), MotorNoise()),
        ),
    ],
    "a sensor, and no wall to see": [
        Task("WalkerLooking", "Walker2d", (RangeSensor(),)),
        Task("WalkerBlurred", "Walker2d", (RangeSensor(), SensorNoise(dropout=0.5))),
    ],
    "walls of several sizes and places": [
        Task("CheetahNear", "HalfCheetah", (RangeSensor(), Wall(nearest=0.6, farthest=0.7))),
        Task("CheetahFar", "HalfCheetah", (RangeSensor(), Wall(nearest=5.0, farthest=9.0))),
        Task("CheetahHigh", "HalfCheetah", (RangeSensor(), Wall(height=1.0, nearest=1.0, farthest=1.5))),
    ],
    "a wall that is felt and not seen": [Task("HumanoidBlind", "Humanoid", (Wall(width=10.0, nearest=0.5),))],
    "goals that move from fixed places": [
        Task("PusherTracking", "Pusher", (TrackingGoal(0.5),), max_steps=40),
        Task("PusherMoving", "Pusher", (MovingGoal(), MotorNoise()), max_steps=50),
    ],
    "a ball that starts elsewhere": [
        Task("StrikerBoth", "Striker", (MovingStart(), TrackingGoal(), MotorNoise(0.02)), max_steps=60)
    ],
}


@pytest.mark.parametrize("case", CUSTOM)
def test_custom_tasks(case: str) -> None:
    assert_bitwise_equal(CUSTOM[case], num_envs=2 * len(CUSTOM[case]), steps=150)


@pytest.mark.parametrize("body", ["Hopper", "HalfCheetah", "Humanoid", "Pusher", "Striker"])
def test_costs_use_the_precision_of_the_actions(body: str) -> None:
    assert_bitwise_equal([body], num_envs=2, steps=60, dtype=np.float64)


def test_an_unknown_runtime_variation_is_stepped_through_single_environments() -> None:
    class Whim(RuntimeVariation):
        """Something new at run time."""

    env = envs.make_vec(Task("HopperWhim", "Hopper", (Whim(),)), 2)
    assert type(env).__name__ == "SequentialVectorEnv"
