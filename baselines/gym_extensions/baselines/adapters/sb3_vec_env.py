"""Stable-Baselines3's ``VecEnv`` over a Gymnasium vector environment."""

from collections.abc import Iterable
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.errors import BenchError

Indices = int | Iterable[int] | None
Infos = list[dict[str, Any]]


def float32_space(space: gym.Space[Any]) -> gym.Space[Any]:
    """A box as a box of float32, in which SB3's networks compute; any other space unchanged."""
    if not isinstance(space, gym.spaces.Box) or not np.issubdtype(space.dtype, np.floating):
        return space
    return gym.spaces.Box(space.low.astype(np.float32), space.high.astype(np.float32), dtype=np.float32)


class BatchVecEnv(VecEnv):
    """An SB3 ``VecEnv`` over a Gymnasium vector environment in autoreset mode NEXT_STEP.

    SB3 expects the first observation of the next episode together with the last reward of the old one.
    Environments whose episode ended are therefore reset at once, by ``reset_mask``. Floating-point
    observations are float32. ``seed(seed)`` seeds the next reset, as in SB3's own environments.

    Raises ``BenchError`` for the mode SAME_STEP, which gives no last observation of an episode.
    """

    def __init__(self, env: VectorEnv) -> None:
        if getattr(env, "metadata", {}).get("autoreset_mode") is AutoresetMode.SAME_STEP:
            hint = "Make the environments with autoreset_mode=AutoresetMode.NEXT_STEP, the default."
            raise BenchError("bad-autoreset-mode", "The mode is SAME_STEP.", "BatchVecEnv", hint)
        self.env = env
        self._actions: Array = np.zeros(0)
        self._returns, self._lengths = np.zeros(env.num_envs), np.zeros(env.num_envs, int)
        self.render_mode = None
        space = float32_space(env.single_observation_space)
        self._dtype = space.dtype
        super().__init__(env.num_envs, space, env.single_action_space)

    def reset(self) -> Array:
        """The first observations of all environments."""
        seeds: Any = None if self._seeds[0] is None else self._seeds
        observations, _ = self.env.reset(seed=seeds)
        self._reset_seeds()
        self._returns[:], self._lengths[:] = 0.0, 0
        return np.array(observations, self._dtype)

    def step_async(self, actions: Array) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Array, Array, Array, Infos]:
        """Steps all environments and resets those whose episode ended.

        Returns:
            Observations, rewards, dones and infos. The info of an ended episode holds its last observation
            and what SB3 logs: return ``r``, length ``l`` and, where the task defines it, ``is_success``.
        """
        result, rewards, terminated, truncated, info = self.env.step(self._actions)
        observations, dones = np.array(result, self._dtype), np.asarray(terminated | truncated)
        self._returns += rewards
        self._lengths += 1
        infos: Infos = [{} for _ in range(self.num_envs)]
        if dones.any():
            for i in map(int, np.flatnonzero(dones)):
                infos[i] = {
                    "terminal_observation": observations[i].copy(),
                    "TimeLimit.truncated": bool(truncated[i] and not terminated[i]),
                    "episode": {"r": float(self._returns[i]), "l": int(self._lengths[i])},
                }
                if "is_success" in info:
                    infos[i]["is_success"] = bool(info["is_success"][i])
            self._returns[dones], self._lengths[dones] = 0.0, 0
            first, _ = self.env.reset(options={"reset_mask": dones})
            observations[dones] = np.asarray(first)[dones]
        return observations, np.array(rewards, np.float32), dones, infos

    def close(self) -> None:
        """Does nothing, because the caller owns the vector environment."""

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """The vector environment's attribute, repeated per environment."""
        value = getattr(self.env, attr_name) if attr_name != "render_mode" else None
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Raises NotImplementedError, because the environments share one simulation."""
        raise NotImplementedError("attributes of one environment in a batch cannot be set")

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """The result of a method call, per environment."""
        results = self.env.call(method_name, *method_args, **method_kwargs)  # type: ignore[attr-defined]
        return [results[i] for i in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:
        """False per environment: a vector environment has no single-environment wrappers."""
        return [False for _ in self._get_indices(indices)]


class SpacesEnv(gym.Env[Any, Any]):
    """Spaces without dynamics, enough to build a policy."""

    def __init__(self, observation_space: gym.Space[Any], action_space: gym.Space[Any]) -> None:
        self.observation_space, self.action_space = float32_space(observation_space), action_space
