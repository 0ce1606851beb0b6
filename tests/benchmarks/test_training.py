"""Training: TRPO end to end with the paper's batches, against raw physics and SB3's TRPO."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import pytest
from mujoco.batch import Batch

from gym_extensions.baselines.algorithms import factory
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.catalog.budgets import budget
from gym_extensions.catalog.registry import task
from gym_extensions.envs import make, make_vec

pytestmark = pytest.mark.bench

LANES, THREADS, BODY = 64, 2, "Hopper"
BATCH = budget("paper").batch_steps
STEPS = -(-BATCH // LANES)
"""Vector steps in which every lane makes its part of a batch."""
PEER_BATCH = STEPS * LANES


def reference() -> tuple[Any, Any]:
    """TRPO with the paper's settings and its environment, recorded as in a submission."""
    env: Any = make_vec(BODY, LANES, num_threads=THREADS)
    agent = factory("trpo-2017")(env.single_observation_space, env.single_action_space, 0)
    endless = 10**12
    return agent, Recorder(env, [task(BODY).id], steps=endless, batch_steps=BATCH, seed=0)


def engine_alone() -> Callable[[], tuple[int, float]]:
    """A turn of raw physics: the states and actions of an untrained policy, the engine's own time counted."""
    agent, env = reference()
    single: Any = make(BODY).unwrapped
    raw = Batch(single.model, LANES, THREADS)
    ctrl = raw.bind("ctrl")

    def turn() -> tuple[int, float]:
        observations, _ = env.reset()
        seconds = 0.0
        for _ in range(STEPS):
            for name, values in env.env.save_states().items():
                raw.bind(name)[...] = values
            actions = agent.act(observations)
            ctrl[...] = actions.clip(-1, 1)
            start = time.perf_counter()
            raw.step(nstep=single.frame_skip)
            seconds += time.perf_counter() - start
            observations, *_ = env.step(actions)
        return PEER_BATCH, seconds

    return turn


def peer(lanes: int, processes: bool) -> Callable[[], tuple[int, float]]:
    """A turn of one batch of SB3's TRPO with the paper's settings."""
    import torch
    from sb3_contrib import TRPO
    from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

    torch.set_num_threads(1 if processes else THREADS)
    kind: Any = SubprocVecEnv if processes else DummyVecEnv
    steps = -(-BATCH // lanes)
    model = TRPO(
        "MlpPolicy",
        kind([lambda: gym.make(f"{BODY}-v5")] * lanes),
        n_steps=steps,
        batch_size=steps * lanes // 16,
        gamma=0.99,
        gae_lambda=1.0,
        cg_damping=1e-5,
        target_kl=0.01,
        policy_kwargs={"net_arch": {"pi": [100, 50, 25], "vf": [64, 64]}, "activation_fn": torch.nn.ReLU},
        device="cpu",
        seed=0,
    )

    def turn() -> tuple[int, float]:
        start = time.perf_counter()
        model.learn(steps * lanes, reset_num_timesteps=False)
        return steps * lanes, time.perf_counter() - start

    return turn


def test_trpo_from_end_to_end(side_by_side: Any) -> None:
    agent, env = reference()

    def ours() -> tuple[int, float]:
        start, before = time.perf_counter(), env.taken
        agent.learn(env, BATCH)
        return env.taken - before, time.perf_counter() - start

    contestants = {
        "trpo": ours,
        "Batch.step": engine_alone(),
        "SB3, DummyVecEnv(64)": peer(LANES, processes=False),
        "SB3, SubprocVecEnv(4)": peer(4, processes=True),
    }
    bars = {"Batch.step": 0.85, "SB3, DummyVecEnv(64)": 3.5}
    side_by_side("training", contestants, bars=bars, rounds=3, task=BODY, batch=BATCH, threads=THREADS)
