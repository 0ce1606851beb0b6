"""Stepping: against the engine with nothing around it, and what else a user would take; peak memory."""

import importlib
import importlib.util
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from mujoco.batch import Batch

from gym_extensions import envs
from tools.benchmarks.conftest import Turn

pytestmark = pytest.mark.bench

NUM_ENVS, THREADS = 64, 2
STEPS = {"Hopper": 60, "Walker2d": 60, "HalfCheetah": 120, "Humanoid": 15, "Pusher": 120}
"""Vector steps per turn: a fraction of a second for each body."""
BODIES = tuple(STEPS)
RAW_BAR = {"Humanoid": 0.85}
ENVPOOL_BAR = {"Hopper": 0.95}
SYNC_BAR = {"Walker2d": 2.6, "Humanoid": 2.3}
ONE_ENVIRONMENT_BAR = {"Hopper": 2.0, "HalfCheetah": 2.0, "Humanoid": 1.2}
"""Bars of the speed of 64 environments over that of one, per environment step."""
NAVIGATION = {
    "Limited-Range-Based": (2000, 20, 8.0),
    "State-Based": (2000, 20, 12.0),
    "Image-Based": (40, 10, 5.0),
}
"""Vector steps per turn, ours and Gymnasium's, and the bar of the ratio of our speed to Gymnasium's."""
MEMORY = """
import numpy as np
from gym_extensions.baselines.training.checkpoints import peak_memory_mb
from gym_extensions.envs import make_vec
env = make_vec("Humanoid", 512, num_threads=2)
env.reset(seed=0)
for _ in range(20):
    env.step(np.full((512, 17), 0.3, np.float32))
print(peak_memory_mb())
"""
"""A program that prints its peak memory in MB."""


def drawn(space: Any, steps: int, num_envs: int) -> Any:
    """Random actions, float32."""
    generator = np.random.default_rng(0)
    return generator.uniform(space.low, space.high, (steps, num_envs, *space.shape)).astype(np.float32)


def stepping(step: Callable[[Any], object], actions: Any) -> Turn:
    """A turn of vector steps of an environment that was reset, with actions (steps, num_envs, …)."""

    def turn() -> tuple[int, float]:
        start = time.perf_counter()
        for row in actions:
            step(row)
        return actions.shape[0] * actions.shape[1], time.perf_counter() - start

    return turn


def started(env: gym.vector.VectorEnv[Any, Any, Any], steps: int) -> Turn:
    """A turn of random vector steps of an environment."""
    env.reset(seed=0)
    return stepping(env.step, drawn(env.single_action_space, steps, env.num_envs))


@pytest.mark.parametrize("body", BODIES)
def test_make_vec_against_raw_physics(side_by_side: Any, body: str) -> None:
    env: Any = envs.make_vec(body, NUM_ENVS, num_threads=THREADS)
    single: Any = envs.make(body).unwrapped
    actions = drawn(env.single_action_space, STEPS[body], NUM_ENVS)
    raw = Batch(single.model, NUM_ENVS, THREADS)
    ctrl = raw.bind("ctrl")
    env.reset(seed=0)
    spent = {"raw": 0.0}

    def batch() -> tuple[int, float]:
        """Steps both in turn from the same states; the time of raw physics is stored for its own turn."""
        spent["raw"], seconds = 0.0, 0.0
        for row in actions:
            for name, values in env.states().items():
                raw.bind(name)[...] = values  # the engine's warm start is that of its own last step
            ctrl[...] = row
            start = time.perf_counter()
            raw.step(nstep=single.frame_skip)
            between = time.perf_counter()
            env.step(row)
            spent["raw"] += between - start
            seconds += time.perf_counter() - between
        return len(actions) * NUM_ENVS, seconds

    contestants = {"make_vec": batch, "Batch.step": lambda: (len(actions) * NUM_ENVS, spent["raw"])}
    bars = {"Batch.step": RAW_BAR.get(body, 0.95)}
    about = {"task": body, "environments": NUM_ENVS, "threads": THREADS}
    side_by_side("stepping, raw", contestants, bars=bars, **about)


@pytest.mark.parametrize("body", BODIES)
def test_make_vec_against_other_vector_environments(side_by_side: Any, body: str) -> None:
    ours, steps, gym_id = envs.make_vec(body, NUM_ENVS, num_threads=THREADS), STEPS[body], f"{body}-v5"
    contestants = {
        "make_vec": started(ours, steps),
        "SyncVectorEnv(64)": started(gym.make_vec(gym_id, NUM_ENVS, "sync"), max(steps // 4, 4)),
    }
    bars = {"SyncVectorEnv(64)": SYNC_BAR.get(body, 3.0)}
    if importlib.util.find_spec("envpool"):
        envpool: Any = importlib.import_module("envpool")
        pool = envpool.make(gym_id, env_type="gymnasium", num_envs=NUM_ENVS, num_threads=THREADS)
        pool.reset()
        actions = drawn(ours.single_action_space, steps, NUM_ENVS).astype(np.float64)  # of its own type
        contestants["EnvPool"] = stepping(pool.step, actions)
        bars["EnvPool"] = ENVPOOL_BAR.get(body, 1.0)
    about = {"task": body, "environments": NUM_ENVS, "threads": THREADS}
    side_by_side("stepping, peers", contestants, bars=bars, **about)


@pytest.mark.parametrize("body", ["Hopper", "HalfCheetah", "Humanoid"])
def test_many_environments_are_faster_per_step_than_one(side_by_side: Any, body: str) -> None:
    contestants = {}
    for num_envs in (64, 1, 4, 16, 256, 512):
        env = envs.make_vec(body, num_envs, num_threads=THREADS)
        name = f"{num_envs} environment{'s' if num_envs > 1 else ''}"
        contestants[name] = started(env, max(2, STEPS[body] * NUM_ENVS // 4 // num_envs))
    bars = {"1 environment": ONE_ENVIRONMENT_BAR[body]}
    ratios = side_by_side(
        "number of environments", contestants, bars=bars, rounds=5, task=body, threads=THREADS
    )
    assert ratios["1 environment"] > 1.0


@pytest.mark.parametrize("body", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid"])
def test_a_wall_and_sensor_cost_little(side_by_side: Any, body: str) -> None:
    contestants = {}
    for name in (f"{body}Wall", body):
        contestants[name] = started(envs.make_vec(name, NUM_ENVS, num_threads=THREADS), STEPS[body])
    about = {"task": f"{body}Wall", "environments": NUM_ENVS, "threads": THREADS}
    side_by_side("wall and sensor", contestants, bars={body: 0.85}, **about)


@pytest.mark.parametrize("family", NAVIGATION)
def test_navigation_is_faster_than_gymnasiums_sync_vector_env(side_by_side: Any, family: str) -> None:
    steps, peer_steps, bar = NAVIGATION[family]
    name, peer = f"{family}-Navigation-2d-Map0-Goal0", f"SyncVectorEnv({NUM_ENVS})"
    ours, sync = envs.make_vec(name, NUM_ENVS), gym.vector.SyncVectorEnv([lambda: envs.make(name)] * NUM_ENVS)
    contestants = {"make_vec": started(ours, steps), peer: started(sync, peer_steps)}
    about = {"task": family, "environments": NUM_ENVS, "threads": 1}
    side_by_side("navigation", contestants, bars={peer: bar}, **about)


def test_512_humanoid_environments_need_at_most_1_5_gb(side_by_side: Any) -> None:
    """The ratio is 1.5 GB / peak memory of the whole process, so above 1 is good."""

    def turn() -> tuple[int, float]:
        done = subprocess.run([sys.executable, "-c", MEMORY], check=True, capture_output=True, text=True)
        return 1, float(done.stdout) / 1500

    contestants = {"512 Humanoid environments": turn, "1.5 GB": lambda: (1, 1.0)}
    ratios = side_by_side("memory", contestants, bars={"1.5 GB": 1.0}, rounds=1)
    assert ratios["1.5 GB"] >= 1.0
