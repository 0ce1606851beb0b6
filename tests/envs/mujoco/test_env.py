"""Vector environments equal Gymnasium's vector of the single environments bit for bit, infos included."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from gym_extensions import envs
from gym_extensions.catalog.bodies import Body
from gym_extensions.catalog.tasks import TASKS, Task, task
from gym_extensions.catalog.variations import Course, RangeSensor, Variation, Wall

from ..test_vector_env import plain

SEED, SCALE = 5, 1.2
BEFORE_LIMIT = 4


def assert_bitwise_equal(
    tasks: Sequence[str | Task], num_envs: int, steps: int, dtype: type = np.float32, after: int = 0
) -> None:
    """Steps a vector environment beside Gymnasium's own and compares every number.

    Args:
        tasks: environment i has ``tasks[i % len(tasks)]``.
        num_envs: number of environments.
        steps: number of steps.
        dtype: of the actions.
        after: more steps, before which the time limits of all environments are 4 steps away.
    """
    vector: Any = envs.make_vec(tasks, num_envs)
    singles: Any = SyncVectorEnv([partial(envs.make, tasks[index % len(tasks)]) for index in range(num_envs)])
    assert plain(vector.reset(seed=SEED)) == plain(singles.reset(seed=SEED))
    generator = np.random.default_rng(SEED)
    space = vector.single_action_space
    for step in range(steps + after):
        if step == steps:
            vector._elapsed[:] = vector._limits - BEFORE_LIMIT
            for env, limit in zip(singles.envs, vector._limits, strict=True):
                env._elapsed_steps = limit - BEFORE_LIMIT
        actions = generator.uniform(SCALE * space.low, SCALE * space.high, (num_envs, *space.shape))
        result = vector.step(actions.astype(dtype))
        assert plain(result) == plain(singles.step(actions.astype(dtype))), f"step {step}"
        if after and step == steps + BEFORE_LIMIT - 1:
            assert result[3].any()
    assert result[0].dtype == vector.single_observation_space.dtype
    vector.close()


def side_by_side() -> dict[str, list[str]]:
    """Every published task, grouped by equal spaces."""
    kinds: dict[str, list[str]] = {}
    for each in TASKS.values():
        sensor = any(isinstance(variation, RangeSensor) for variation in each.variations)
        families = [variation.family for variation in each.variations if isinstance(variation, Course)]
        kind = " ".join([each.base, *families, *(["with sensor"] if sensor else [])])
        kinds.setdefault(kind, []).append(each.id)
    return kinds


KINDS = side_by_side()


@pytest.mark.parametrize("kind", KINDS)
def test_every_published_task(kind: str) -> None:
    assert_bitwise_equal(KINDS[kind], num_envs=len(KINDS[kind]), steps=30, after=8)


@pytest.mark.parametrize(
    "tasks",
    [["HalfCheetahGravityHalf", "HalfCheetahMotorNoise"], ["HalfCheetahNoisyWall"], ["PusherTrackingGoal"]],
)
def test_whole_episodes(tasks: list[str]) -> None:
    assert_bitwise_equal(tasks, num_envs=len(tasks), steps=1005)


@dataclass(frozen=True)
class Raised(Variation):
    """Moves the torso up: a variation of a user."""

    height: float

    def apply(self, body: Body, spec: Any) -> None:
        x, y, z = spec.body("torso").pos
        spec.body("torso").pos = [x, y, z + self.height]


MODEL, SEEN = (envs.Gravity(0.7), envs.LimbScale("Foot", 1.2)), (RangeSensor(), Wall(), envs.SensorNoise())
MOVING = (envs.MovingStart(), envs.TrackingGoal(), envs.MotorNoise(0.02))
CUSTOM: dict[str, list[Task]] = {
    "sensors at several heights": [
        Task("CheetahWall", "HalfCheetah", (RangeSensor(), Wall())),
        Task("CheetahRaised", "HalfCheetah", (RangeSensor(), Wall(), Raised(0.1))),
    ],
    "everything at once on one body": [Task("HopperBusy", "Hopper", (*MODEL, *SEEN, envs.MotorNoise()))],
    "a sensor, and no wall to see": [
        Task("WalkerLooking", "Walker2d", (RangeSensor(),)),
        Task("WalkerBlurred", "Walker2d", (RangeSensor(), envs.SensorNoise(dropout=0.5))),
    ],
    "walls of several sizes and places": [
        Task("CheetahNear", "HalfCheetah", (RangeSensor(), Wall(nearest=0.6, farthest=0.7))),
        Task("CheetahFar", "HalfCheetah", (RangeSensor(), Wall(nearest=5.0, farthest=9.0))),
        Task("CheetahHigh", "HalfCheetah", (RangeSensor(), Wall(height=1.0, nearest=1.0, farthest=1.5))),
    ],
    "a wall that is felt and not seen": [Task("HumanoidBlind", "Humanoid", (Wall(width=10.0, nearest=0.5),))],
    "goals that move from fixed places": [
        Task("PusherTracking", "Pusher", (envs.TrackingGoal(0.5),), max_steps=40),
        Task("PusherMoving", "Pusher", (envs.MovingGoal(), envs.MotorNoise()), max_steps=50),
    ],
    "two tasks, of which one reports success": [task("Humanoid"), task("HumanoidStandup")],
    "a ball that starts elsewhere": [Task("StrikerBoth", "Striker", MOVING, max_steps=60)],
}


@pytest.mark.parametrize("case", CUSTOM)
def test_custom_tasks(case: str) -> None:
    assert_bitwise_equal(CUSTOM[case], num_envs=2 * len(CUSTOM[case]), steps=60)


@pytest.mark.parametrize("body", ["Hopper", "HalfCheetah", "Humanoid", "Pusher", "Striker"])
def test_costs_use_the_precision_of_the_actions(body: str) -> None:
    assert_bitwise_equal([body], num_envs=2, steps=40, dtype=np.float64)


def test_stable_baselines3_vector_environments_accept_the_tasks() -> None:
    vec = pytest.importorskip("stable_baselines3.common.vec_env")
    env = vec.DummyVecEnv([lambda: envs.make("HopperWall"), lambda: envs.make("HopperWithSensor")])
    env.seed(0)
    assert env.reset().shape == (2, 21)
    assert env.step(np.zeros((2, 3), np.float32))[0].shape == (2, 21)
    env.close()
