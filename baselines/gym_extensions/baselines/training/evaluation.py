"""Evaluation of an agent on one task: one episode per environment, recorded for replay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from gym_extensions.baselines.agent import Agent, Array, Context, VectorEnv
from gym_extensions.baselines.context import TaskLabel
from gym_extensions.baselines.context_checks import action_function
from gym_extensions.baselines.training.actions import clip_actions
from gym_extensions.rollouts.traces import Trace, cut


@runtime_checkable
class BatchedStates(Protocol):
    """A vector environment that returns the states of all environments in one call."""

    def save_states(self) -> dict[str, Array]:
        """Arrays (num_envs, …) by name."""


@dataclass(frozen=True)
class Rollout:
    """One evaluation episode, with its trace if one was requested."""

    length: int
    return_: float
    terminated: bool
    trace: Trace | None = None


def saved_states(env: VectorEnv) -> dict[str, Array]:
    """The states of all environments: arrays (num_envs, …) by name."""
    if isinstance(env, BatchedStates):
        return env.save_states()
    states = env.call("save_state")  # type: ignore[attr-defined]
    return {name: np.stack([state[name] for state in states]) for name in states[0]}


def evaluate(
    agent: Agent,
    env: VectorEnv,
    seeds: Sequence[int],
    segment_steps: int = 0,
    label: TaskLabel | None = None,
) -> list[Rollout]:
    """Runs the first episode of every environment.

    An environment whose episode ended is stepped on, so that no action depends on when another episode ended.

    Args:
        agent: acts and does not learn.
        env: ``len(seeds)`` environments of one task.
        seeds: the reset seed of each environment.
        segment_steps: steps per segment of a trace; 0 records no traces.
        label: the task, only for an agent that asked for ``task_in_evaluation``.

    Returns:
        One rollout per seed, in the order of ``seeds``.
    """
    num_envs, act = len(seeds), action_function(agent)
    observations, _ = env.reset(seed=list(seeds))  # type: ignore[arg-type]
    rewards, actions, states = [], [], []
    lengths, is_terminated = np.zeros(num_envs, int), np.zeros(num_envs, bool)
    starts, resetting = np.ones(num_envs, bool), np.zeros(num_envs, bool)
    while not lengths.all():
        applied = clip_actions(act(observations, Context(starts, label)), env, "act()")
        observations, reward, terminated, truncated, _ = env.step(applied)
        rewards.append(np.array(reward, np.float64))
        starts, resetting = resetting, terminated | truncated
        ended = resetting & (lengths == 0)
        is_terminated[ended] = terminated[ended]
        lengths[ended] = len(rewards)
        if segment_steps:
            actions.append(np.array(applied))
            if (len(rewards) + 1) % segment_steps == 0 and not lengths.all():
                states.append(saved_states(env))
    all_rewards = np.stack(rewards)
    all_actions = np.stack(actions) if actions else None
    rollouts = []
    for i in range(num_envs):
        episode_rewards = all_rewards[: lengths[i], i]
        trace = None
        if all_actions is not None:
            episode_states = [{name: values[i] for name, values in state.items()} for state in states]
            trace = cut(all_actions[: lengths[i], i], episode_rewards, episode_states, segment_steps)
        rollouts.append(Rollout(int(lengths[i]), math.fsum(episode_rewards), bool(is_terminated[i]), trace))
    return rollouts
