"""The batch gives what the single environments give, bit for bit."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions import envs
from gym_extensions.catalog.groups import group
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


@pytest.mark.parametrize("body", ["hopper", "walker2d", "halfcheetah", "humanoid"])
def test_a_batch_of_a_gravity_group_is_its_single_environments_bit_for_bit(body: str) -> None:
    lockstep(list(group(f"{body}-gravity").task_ids), lanes=5, steps=STEPS + 10)
