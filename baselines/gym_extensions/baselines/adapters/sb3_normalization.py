"""Running statistics of observations and rewards, kept across stages, through SB3's ``VecNormalize``."""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from gym_extensions.baselines.agent import Array

STATISTICS = ("obs_rms", "ret_rms")
"""The statistics that a ``VecNormalize`` keeps: of observations, and of discounted returns."""


class Normalization:
    """Normalizes an agent's observations and rewards by running statistics, or neither.

    The statistics change in training only. Rewards are scaled for the model alone, not in the log.

    Args:
        observations: whether observations are standardized and clipped to ±10.
        rewards: whether rewards are divided by the standard deviation of the discounted return.
    """

    def __init__(self, observations: bool, rewards: bool) -> None:
        self._observations, self._rewards = observations, rewards
        self._wrapper: VecNormalize | None = None

    def wrap(self, env: VecEnv, discount: float) -> VecEnv:
        """The environment with normalized observations and rewards, which continues the statistics so far."""
        if not (self._observations or self._rewards):
            return env
        former = self._wrapper
        self._wrapper = VecNormalize(
            env, norm_obs=self._observations, norm_reward=self._rewards, gamma=discount
        )
        if former is not None:
            for name in self._names():
                setattr(self._wrapper, name, getattr(former, name))
        return self._wrapper

    def normalize(self, observations: Array) -> Array:
        """Observations (num_envs, …) as the model expects them. The statistics do not change."""
        return (
            observations if self._wrapper is None else np.asarray(self._wrapper.normalize_obs(observations))
        )

    def observation_statistics(self) -> tuple[Array, Array, float] | None:
        """Mean, standard deviation and limit of standardized observations; None if they are not changed."""
        if self._wrapper is None or not self._observations:
            return None
        statistics: Any = self._wrapper.obs_rms
        deviation = np.sqrt(statistics.var + self._wrapper.epsilon)
        return statistics.mean, deviation, float(self._wrapper.clip_obs)

    def state(self) -> dict[str, Any]:
        """Mean, variance and count of every statistic, by name."""
        return {name: dict(vars(getattr(self._wrapper, name))) for name in self._names()}

    def restore(self, state: dict[str, Any]) -> None:
        """Sets the statistics to a state of :meth:`state`."""
        for name, values in state.items():
            statistics = RunningMeanStd()
            vars(statistics).update(values)
            setattr(self._wrapper, name, statistics)

    def _names(self) -> list[str]:
        return [name for name in STATISTICS if hasattr(self._wrapper, name)]
