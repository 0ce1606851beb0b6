"""One cell of the evaluation matrix: every episode a lane of a vector environment, recorded for replay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from gym_extensions.baselines.agent import Agent, Array, VectorEnv
from gym_extensions.baselines.training.actions import clipped
from gym_extensions.rollouts.traces import Trace, cut


@runtime_checkable
class StatesAtOnce(Protocol):
    """A vector environment that gives the states of all lanes in one call."""

    def save_states(self) -> dict[str, Array]:
        """Arrays by name, (lanes, …)."""


@dataclass(frozen=True)
class Rollout:
    """One evaluated episode: what the log's row needs, and its trace when one was asked for."""

    length: int
    return_: float
    terminated: bool
    trace: Trace | None = None


def saved_states(env: VectorEnv) -> dict[str, Array]:
    """The state of every lane, by name, (lanes, …)."""
    if isinstance(env, StatesAtOnce):
        return env.save_states()
    lanes = env.call("save_state")  # type: ignore[attr-defined]
    return {name: np.stack([lane[name] for lane in lanes]) for name in lanes[0]}


def evaluate(agent: Agent, env: VectorEnv, seeds: Sequence[int], segment_steps: int = 0) -> list[Rollout]:
    """The first episode of every lane, in the order of ``seeds``, one a lane.

    A lane that has ended keeps its place, so that no lane's actions depend on when another ended.
    With ``segment_steps`` above 0 each episode has its trace, cut into segments of so many steps.
    """
    lanes = len(seeds)
    observations, _ = env.reset(seed=list(seeds))  # type: ignore[arg-type]
    rewards, actions, states = [], [], []
    lengths, terminated = np.zeros(lanes, int), np.zeros(lanes, bool)
    while not lengths.all():
        applied = clipped(agent.act(observations), env, "act()")
        observations, reward, ends, cuts, _ = env.step(applied)
        rewards.append(np.array(reward, np.float64))
        ended = (ends | cuts) & (lengths == 0)
        terminated[ended] = ends[ended]
        lengths[ended] = len(rewards)
        if segment_steps:
            actions.append(np.array(applied))
            if (len(rewards) + 1) % segment_steps == 0 and not lengths.all():
                states.append(saved_states(env))
    columns = np.stack(rewards)
    played = np.stack(actions) if actions else None
    rollouts = []
    for lane in range(lanes):
        earned = columns[: lengths[lane], lane]
        trace = None
        if played is not None:
            own = [{name: rows[lane] for name, rows in kept.items()} for kept in states]
            trace = cut(played[: lengths[lane], lane], earned, own, segment_steps)
        rollouts.append(Rollout(int(lengths[lane]), math.fsum(earned), bool(terminated[lane]), trace))
    return rollouts
