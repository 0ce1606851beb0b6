"""Training from end to end, against raw physics: TRPO with the paper's batches, and the reference agent."""

import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import pytest
from mujoco.batch import Batch

from gym_extensions.baselines.algorithms import factory
from gym_extensions.baselines.training.environment import TrainingEnv
from gym_extensions.catalog.protocol import Budget, budget
from gym_extensions.catalog.tasks import task
from gym_extensions.envs import make, make_vec
from tools.benchmarks.conftest import Turn

pytestmark = pytest.mark.bench

NUM_ENVS, THREADS, BODY = 64, 2, "Hopper"
BATCH = budget("paper").batch_steps
STEPS = -(-BATCH // NUM_ENVS)
"""Vector steps in which every environment makes its part of a batch."""
CHUNKS = {
    "Hopper": (20_000, 0.8),
    "HopperWall": (20_000, 0.8),
    "Walker2d": (20_000, 0.8),
    "Walker2dWall": (20_000, 0.8),
    "HalfCheetah": (20_000, 0.7),
    "HalfCheetahWall": (20_000, 0.7),
    "Humanoid": (10_000, 0.65),
}
"""Per task: the training steps of a turn of the reference agent, and the share of raw physics to reach."""
Clock = Callable[[], float]


def trained(agent_name: str, name: str, named: Budget, num_envs: int, threads: int) -> tuple[Any, Any]:
    """An agent and its training environment on a task, recorded as in a submission."""
    env: Any = make_vec(name, num_envs, num_threads=threads)
    agent = factory(agent_name)(env.single_observation_space, env.single_action_space, 0)
    endless = 10**12
    return agent, TrainingEnv(env, [task(name).id], steps=endless, batch_steps=named.batch_steps, seed=0)


def training(agent: Any, env: Any, steps: int, clock: Clock = time.perf_counter) -> Turn:
    """A turn of training, which continues where the last one ended."""

    def turn() -> tuple[int, float]:
        start, before = clock(), env.taken
        agent.learn(env, steps)
        return env.taken - before, clock() - start

    return turn


def engine_alone(
    agent: Any, name: str, num_envs: int, threads: int, steps: int, *, clock: Clock = time.perf_counter
) -> Turn:
    """A turn of raw physics: the states and actions of the agent's policy, the engine's own time counted."""
    env: Any = make_vec(name, num_envs, num_threads=threads)
    single: Any = make(name).unwrapped
    raw = Batch(single.model, num_envs, threads)
    ctrl = raw.bind("ctrl")
    low, high = single.action_space.low, single.action_space.high

    def turn() -> tuple[int, float]:
        observations, _ = env.reset()
        seconds = 0.0
        for _ in range(steps):
            for field, values in env.states().items():
                raw.bind(field)[...] = values  # the engine's warm start is that of its own last step
            actions = agent.act(observations)
            ctrl[...] = actions.clip(low, high)
            start = clock()
            raw.step(nstep=single.frame_skip)
            seconds += clock() - start
            observations, *_ = env.step(actions)
        return steps * num_envs, seconds

    return turn


def peer() -> Turn:
    """A turn of one batch of SB3's TRPO with the paper's settings."""
    import torch
    from sb3_contrib import TRPO
    from stable_baselines3.common.vec_env import DummyVecEnv

    torch.set_num_threads(THREADS)
    model = TRPO(
        "MlpPolicy",
        DummyVecEnv([lambda: gym.make(f"{BODY}-v5")] * NUM_ENVS),
        n_steps=STEPS,
        batch_size=STEPS * NUM_ENVS // 16,
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
        model.learn(STEPS * NUM_ENVS, reset_num_timesteps=False)
        return STEPS * NUM_ENVS, time.perf_counter() - start

    return turn


def test_trpo_from_end_to_end(side_by_side: Any) -> None:
    agent, env = trained("trpo-2017", BODY, budget("paper"), NUM_ENVS, THREADS)
    contestants = {
        "trpo": training(agent, env, BATCH),
        "Batch.step": engine_alone(agent, BODY, NUM_ENVS, THREADS, STEPS),
        "SB3, DummyVecEnv(64)": peer(),
    }
    bars = {"Batch.step": 0.85, "SB3, DummyVecEnv(64)": 3.5}
    side_by_side("training", contestants, bars=bars, rounds=3, task=BODY, batch=BATCH, threads=THREADS)


@pytest.mark.parametrize("name", CHUNKS)
def test_the_reference_agent_on_one_thread_by_processor_time(side_by_side: Any, name: str) -> None:
    standard = budget("300k")
    chunk, bar = CHUNKS[name]
    agent, env = trained("trpo", name, standard, standard.num_envs, 1)
    steps = chunk // standard.num_envs
    contestants = {
        "trpo": training(agent, env, chunk, time.process_time),
        "Batch.step": engine_alone(agent, name, standard.num_envs, 1, steps, clock=time.process_time),
    }
    about = {"task": name, "batch": standard.batch_steps, "threads": 1}
    side_by_side("training, reference agent", contestants, bars={"Batch.step": bar}, rounds=5, **about)
