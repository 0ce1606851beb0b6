"""Transitions of one batch, gathered from the lanes of a vector environment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv


@dataclass(frozen=True)
class Gathered:
    """T steps of all lanes: observations (T + 1, lanes, o); the rest (T, lanes, …).

    ``real`` is False in the rows in which a lane was being reset.
    """

    observations: Array
    actions: Array
    rewards: Array
    terminated: Array
    truncated: Array
    real: Array


@dataclass
class Lanes:
    """Where the lanes stand between two batches: episodes go on across them."""

    env: VectorEnv
    observations: Array
    resetting: Array

    @classmethod
    def started(cls, env: VectorEnv) -> Lanes:
        """All lanes at the start of an episode."""
        observations, _ = env.reset()
        return cls(env, np.array(observations, np.float32), np.zeros(env.num_envs, bool))


def gather(
    lanes: Lanes, sample: Callable[[Array], Array], to_env: Callable[[Array], Array], transitions: int
) -> Gathered:
    """At least so many real transitions, and fewer than one a lane more; ``lanes`` is moved on."""
    seen, actions, rewards, ends, cuts, real = [lanes.observations], [], [], [], [], []
    count = 0
    while count < transitions:
        action = sample(seen[-1])
        observations, reward, end, cut, _ = lanes.env.step(to_env(action))
        genuine = ~lanes.resetting
        lanes.resetting = (end | cut) & genuine
        count += int(genuine.sum())
        seen.append(np.array(observations, np.float32))
        actions.append(action)
        rewards.append(np.array(reward, np.float64))
        ends.append(np.array(end))
        cuts.append(np.array(cut))
        real.append(genuine)
    lanes.observations = seen[-1]
    return Gathered(*map(np.stack, (seen, actions, rewards, ends, cuts, real)))
