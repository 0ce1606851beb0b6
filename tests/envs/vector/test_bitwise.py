"""The batch gives what the single environments give, bit for bit."""

from __future__ import annotations

from collections.abc import Sequence

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
from gym_extensions.envs.seeding import spawn_seeds

STEPS = 1000
SEED, SCALE = 5, 1.2


def lockstep(tasks: Sequence[str | Task], lanes: int, steps: int, dtype: type = np.float32) -> None:
    """Steps a batch and single environments side by side and compares every number."""
    batch = envs.make_vec(tasks, lanes)
    singles = [envs.make(tasks[lane % len(tasks)]) for lane in range(lanes)]
    seeds = spawn_seeds(SEED, lanes)
    observations, _ = batch.reset(seed=SEED)
    firsts = [env.reset(seed=own)[0] for env, own in zip(singles, seeds, strict=True)]
    assert np.array_equal(observations, firsts)
    generator = np.random.default_rng(SEED)
    space = batch.single_action_space
    assert isinstance(space, gym.spaces.Box)
    ended = [False] * lanes
    for step in range(steps):
        drawn = generator.uniform(SCALE * space.low, SCALE * space.high, (lanes, *space.shape))
        actions = drawn.astype(dtype)
        given = batch.step(actions)
        for lane, env in enumerate(singles):
            wanted = (env.reset()[0], 0.0, False, False) if ended[lane] else env.step(actions[lane])[:4]
            ended[lane] = bool(wanted[2] or wanted[3])
            for part, single in zip(given[:4], wanted, strict=True):
                assert np.array_equal(part[lane], single), (step, lane)
        if step % 100 == 7 or step == steps - 1:
            for saved, env in zip(batch.call("save_state"), singles, strict=True):
                wanted_state = env.unwrapped.save_state()
                assert saved.keys() == wanted_state.keys()
                assert all(np.array_equal(saved[name], wanted_state[name]) for name in saved)
    assert given[0].dtype == observations.dtype == batch.single_observation_space.dtype
    batch.close()


def side_by_side() -> dict[str, list[str]]:
    """Every published task once, those together that share spaces."""
    kinds: dict[str, list[str]] = {}
    for row in TASKS.values():
        sensor = any(isinstance(own, RangeSensor) for own in row.variations)
        kind = f"{row.base} with sensor" if sensor else row.base
        if row.base != "Navigation":
            kinds.setdefault(kind, []).append(row.id)
    return kinds


KINDS = side_by_side()


@pytest.mark.parametrize("kind", KINDS)
def test_a_batch_of_every_task_is_its_single_environments_bit_for_bit(kind: str) -> None:
    lockstep(KINDS[kind], lanes=len(KINDS[kind]), steps=STEPS + 10)


FREE: dict[str, list[Task]] = {
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


@pytest.mark.parametrize("case", FREE)
def test_a_batch_of_free_tasks_is_their_single_environments_bit_for_bit(case: str) -> None:
    lockstep(FREE[case], lanes=2 * len(FREE[case]), steps=150)


@pytest.mark.parametrize("body", ["Hopper", "HalfCheetah", "Humanoid", "Pusher", "Striker"])
def test_costs_keep_the_precision_of_the_actions(body: str) -> None:
    lockstep([body], lanes=2, steps=60, dtype=np.float64)


def test_a_variation_unknown_to_the_arrays_is_not_ignored() -> None:
    class Whim(RuntimeVariation):
        """Something new at run time."""

    env = envs.make_vec(Task("HopperWhim", "Hopper", (Whim(),)), 2)
    assert type(env).__name__ == "SequentialVectorEnv"
