"""The batch gives what the single environments give, bit for bit."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions import envs
from gym_extensions.catalog.scenery import RangeSensor
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.envs.batch import lane_seeds

STEPS = 1000
SEED, SCALE = 5, 1.2


def lockstep(tasks: list[str], lanes: int, steps: int, threads: int = 1) -> None:
    """Steps a batch and single environments side by side and compares every number."""
    batch = envs.make_batch(tasks, lanes, num_threads=threads)
    singles = [envs.make(tasks[lane % len(tasks)]) for lane in range(lanes)]
    seeds = lane_seeds(SEED, lanes)
    observations, _ = batch.reset(seed=SEED)
    firsts = [env.reset(seed=own)[0] for env, own in zip(singles, seeds, strict=True)]
    assert np.array_equal(observations, firsts)
    generator = np.random.default_rng(SEED)
    space = batch.single_action_space
    assert isinstance(space, gym.spaces.Box)
    ended = [False] * lanes
    for step in range(steps):
        drawn = generator.uniform(SCALE * space.low, SCALE * space.high, (lanes, *space.shape))
        actions = drawn.astype(np.float32)
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
