"""Stepping: the batch against the engine with nothing around it, and against what else a user would take."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import mujoco
import numpy as np
import pytest
from mujoco.batch import Batch

from gym_extensions import envs

pytestmark = pytest.mark.bench

LANES, THREADS = 64, 2
STEPS = {"Hopper": 60, "Walker2d": 60, "HalfCheetah": 120, "Humanoid": 15, "Pusher": 120}
"""Vector steps a turn: a fraction of a second for each body."""
BODIES = tuple(STEPS)
RAW_BAR = {"Humanoid": 0.85}
ENVPOOL_BAR = {"Hopper": 0.95}
SYNC_BAR = {"Walker2d": 2.6, "Humanoid": 2.3}


def drawn(space: gym.spaces.Box, steps: int, *lanes: int) -> Any:
    """Random actions, float32."""
    generator = np.random.default_rng(0)
    return generator.uniform(space.low, space.high, (steps, *lanes, *space.shape)).astype(np.float32)


def stepping(env: gym.vector.VectorEnv[Any, Any, Any], given: Any) -> Callable[[], tuple[int, float]]:
    """A turn of vector steps."""
    env.reset(seed=0)

    def turn() -> tuple[int, float]:
        start = time.perf_counter()
        for row in given:
            env.step(row)
        return len(given) * env.num_envs, time.perf_counter() - start

    return turn


def alone(env: gym.Env[Any, Any], given: Any) -> Callable[[], tuple[int, float]]:
    """A turn of one environment's steps, resets included."""
    env.reset(seed=0)

    def turn() -> tuple[int, float]:
        start = time.perf_counter()
        for row in given:
            _, _, terminated, truncated, _ = env.step(row)
            if terminated or truncated:
                env.reset()
        return len(given), time.perf_counter() - start

    return turn


@pytest.mark.parametrize("body", BODIES)
def test_the_batch_against_raw_physics(side_by_side: Any, body: str) -> None:
    env: Any = envs.make_vec(body, LANES, num_threads=THREADS)
    single: Any = envs.make(body).unwrapped
    given = drawn(env.single_action_space, STEPS[body], LANES)
    raw = Batch(single.model, LANES, THREADS)
    ctrl = raw.bind("ctrl")
    env.reset(seed=0)
    spent = {"raw": 0.0}

    def batch() -> tuple[int, float]:
        """Both, a step each in turn, from the same states: raw physics' time is kept for its own turn."""
        spent["raw"], own = 0.0, 0.0
        for row in given:
            for name, values in env.save_states().items():
                if not name.startswith("derived_"):
                    raw.bind(name)[...] = values
            ctrl[...] = row
            start = time.perf_counter()
            raw.step(nstep=single.frame_skip)
            between = time.perf_counter()
            env.step(row)
            spent["raw"] += between - start
            own += time.perf_counter() - between
        return len(given) * LANES, own

    contestants = {"make_vec": batch, "Batch.step": lambda: (len(given) * LANES, spent["raw"])}
    bars = {"Batch.step": RAW_BAR.get(body, 0.95)}
    side_by_side("stepping, raw", contestants, bars=bars, task=body, lanes=LANES, threads=THREADS)


@pytest.mark.parametrize("body", BODIES)
def test_the_batch_against_other_vector_environments(side_by_side: Any, body: str) -> None:
    ours = envs.make_vec(body, LANES, num_threads=THREADS)
    space: Any = ours.single_action_space
    steps = STEPS[body]
    short = max(steps // 4, 4)
    gym_id = f"{body}-v5"
    sync = gym.make_vec(gym_id, LANES, vectorization_mode="sync")
    processes = gym.make_vec(gym_id, 4, vectorization_mode="async")
    contestants = {
        "make_vec": stepping(ours, drawn(space, steps, LANES)),
        "SyncVectorEnv(64)": stepping(sync, drawn(space, short, LANES)),
        "AsyncVectorEnv(4)": stepping(processes, drawn(space, 4 * steps, 4)),
        "Gymnasium single": alone(gym.make(gym_id), drawn(space, short * LANES)),
        "mj_step alone": bare(body, short * LANES),
    }
    bars = {"SyncVectorEnv(64)": SYNC_BAR.get(body, 3.0)}
    if importlib.util.find_spec("envpool"):
        import envpool

        pool = envpool.make(gym_id, env_type="gymnasium", num_envs=LANES, num_threads=THREADS)
        contestants["EnvPool"] = pooled(pool, drawn(space, steps, LANES))
        bars["EnvPool"] = ENVPOOL_BAR.get(body, 1.0)
    side_by_side("stepping, peers", contestants, bars=bars, task=body, lanes=LANES, threads=THREADS)
    processes.close()


def pooled(pool: Any, given: Any) -> Callable[[], tuple[int, float]]:
    """A turn of EnvPool's vector steps; its actions are float64."""
    pool.reset()
    rows = given.astype(np.float64)

    def turn() -> tuple[int, float]:
        start = time.perf_counter()
        for row in rows:
            pool.step(row)
        return len(rows) * LANES, time.perf_counter() - start

    return turn


def bare(body: str, steps: int) -> Callable[[], tuple[int, float]]:
    """A turn of mj_step in one simulation on one thread, reset where its body falls to random actions."""
    single: Any = envs.make(body).unwrapped
    single.reset(seed=0)
    model, data, skip = single.model, single.data, single.frame_skip
    given = drawn(single.action_space, steps)

    def turn() -> tuple[int, float]:
        start = time.perf_counter()
        for index, row in enumerate(given):
            data.ctrl[:] = row
            mujoco.mj_step(model, data, skip)
            if index % 20 == 0:
                mujoco.mj_resetData(model, data)
        return len(given), time.perf_counter() - start

    return turn


@pytest.mark.parametrize("body", ["Hopper", "HalfCheetah", "Humanoid"])
def test_the_cost_of_a_lane_against_their_number(side_by_side: Any, body: str) -> None:
    contestants = {}
    for lanes in (64, 1, 4, 16, 256, 512):
        env = envs.make_vec(body, lanes, num_threads=THREADS)
        steps = max(2, STEPS[body] * LANES // 4 // lanes)
        contestants[f"{lanes} lanes"] = stepping(env, drawn(env.single_action_space, steps, lanes))  # type: ignore[arg-type]
    side_by_side("lanes", contestants, rounds=5, task=body, threads=THREADS)


@pytest.mark.parametrize("body", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid"])
def test_a_wall_with_its_sensor_against_the_same_body_without(side_by_side: Any, body: str) -> None:
    contestants = {}
    for name in (f"{body}Wall", body):
        env = envs.make_vec(name, LANES, num_threads=THREADS)
        contestants[name] = stepping(env, drawn(env.single_action_space, STEPS[body], LANES))  # type: ignore[arg-type]
    side_by_side(
        "wall and sensor", contestants, bars={body: 0.85}, task=f"{body}Wall", lanes=LANES, threads=THREADS
    )


MEMORY = """
import resource
import numpy as np
from gym_extensions.envs import make_vec
env = make_vec("Humanoid", 512, num_threads=2)
env.reset(seed=0)
for _ in range(20):
    env.step(np.full((512, 17), 0.3, np.float32))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_memory_of_512_humanoid_lanes(side_by_side: Any) -> None:
    """The bar is 1.5 GB at the peak, the whole process; here as limit / found, so that above 1 is good."""

    def turn() -> tuple[int, float]:
        said = subprocess.run(
            [sys.executable, "-c", MEMORY], check=True, capture_output=True, text=True
        ).stdout
        return 1, int(said) * 1024 / 1.5e9

    side_by_side(
        "memory", {"512 Humanoid lanes": turn, "1.5 GB": lambda: (1, 1.0)}, bars={"1.5 GB": 1.0}, rounds=1
    )
