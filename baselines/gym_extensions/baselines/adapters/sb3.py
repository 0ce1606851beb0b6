"""Stable-Baselines3 joins in one line, ``make = sb3(PPO, n_steps=250)``; its VecEnv over a batch of ours."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from gym_extensions.baselines.adapters.hyperparameters import as_setting
from gym_extensions.baselines.agent import Array, Card, Factory, Setting, VectorEnv

Infos = list[dict[str, Any]]


class BatchVecEnv(VecEnv):
    """An SB3 VecEnv over a Gymnasium vector environment in autoreset mode NEXT_STEP.

    SB3 wants the first observation of the next episode with the last reward of the old: lanes that ended are
    reset at once, by ``reset_mask``, and no step is lost.
    """

    def __init__(self, env: VectorEnv) -> None:
        self.env = env
        self._actions: Array = np.zeros(0)
        self.render_mode = None
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Array:
        """First observations of all lanes."""
        observations, _ = self.env.reset()
        return np.array(observations)

    def step_async(self, actions: Array) -> None:
        """Keeps the actions for ``step_wait``."""
        self._actions = actions

    def step_wait(self) -> tuple[Array, Array, Array, Infos]:
        """One step of every lane; ended lanes start anew, their last observation being in the infos."""
        observations, rewards, ends, cuts, _ = self.env.step(self._actions)
        done = np.asarray(ends | cuts)
        infos: Infos = [{} for _ in range(self.num_envs)]
        seen = np.array(observations)
        if done.any():
            for lane in map(int, np.flatnonzero(done)):
                truncated = bool(cuts[lane] and not ends[lane])
                infos[lane] = {"terminal_observation": seen[lane].copy(), "TimeLimit.truncated": truncated}
            fresh, _ = self.env.reset(options={"reset_mask": done})
            seen[done] = np.asarray(fresh)[done]
        return seen, np.array(rewards, np.float32), done, infos

    def close(self) -> None:
        """Nothing: who made the batch closes it."""

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """The batch's attribute, once a lane."""
        value = getattr(self.env, attr_name) if attr_name != "render_mode" else None
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: int | Iterable[int] | None = None) -> None:
        """Lanes share one batch: nothing can be set in one of them."""
        raise NotImplementedError("lanes of a batch have no attributes of their own")

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: int | Iterable[int] | None = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """What every lane answers to a call."""
        answers = self.env.call(method_name, *method_args, **method_kwargs)  # type: ignore[attr-defined]
        return [answers[lane] for lane in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """No lane is wrapped in a single environment's wrapper."""
        return [False for _ in self._get_indices(indices)]


class _Spaces(VecEnv):
    """An SB3 VecEnv that has spaces and nothing else: enough to build a policy."""

    def __init__(self, observation_space: gym.Space[Any], action_space: gym.Space[Any], lanes: int) -> None:
        self.render_mode = None
        super().__init__(lanes, observation_space, action_space)

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        return [None for _ in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        return [False for _ in self._get_indices(indices)]

    def _nothing(self, *_: Any, **__: Any) -> Any:
        raise NotImplementedError("these are spaces without an environment")

    reset = step_async = step_wait = close = set_attr = env_method = _nothing


class Sb3Agent:
    """Any SB3 algorithm as an agent; acting has its own state of torch's global generator."""

    def __init__(
        self,
        algorithm: type[BaseAlgorithm],
        spaces: tuple[gym.Space[Any], gym.Space[Any]],
        seed: int,
        deterministic: bool,
        settings: dict[str, Any],
        *,
        told: dict[str, Setting],
    ) -> None:
        self._algorithm, self._spaces, self._settings, self._told = algorithm, spaces, settings, told
        self._seed, self._deterministic = seed % 2**31, deterministic
        torch.set_num_threads(1)
        self._model = self._made(1)
        self._learning = torch.get_rng_state()
        self._acting = torch.Generator().manual_seed(self._seed + 1).get_state()

    def _made(self, lanes: int) -> BaseAlgorithm:
        # SAC and A2C write into the policy_kwargs that they are given.
        given = {key: dict(one) if isinstance(one, dict) else one for key, one in self._settings.items()}
        policy: dict[str, Any] = {"policy": "MlpPolicy", "device": "cpu", "seed": self._seed} | given
        return self._algorithm(env=_Spaces(*self._spaces, lanes), **policy)

    def act(self, observations: Array) -> Array:
        """Actions of the model's policy, sampled or its best."""
        torch.set_rng_state(self._acting)
        actions, _ = self._model.predict(observations, deterministic=self._deterministic)
        self._acting = torch.get_rng_state()
        return np.asarray(actions)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """SB3's own learning, going on from the present model."""
        if self._model.n_envs != env.num_envs:
            trained: Any = self._model.get_parameters()
            self._model = self._made(env.num_envs)
            self._model.set_parameters(trained)
        torch.set_rng_state(self._learning)
        self._model.set_env(BatchVecEnv(env))
        self._model.learn(steps)
        self._learning = torch.get_rng_state()

    def card(self) -> Card:
        """The manifest's words: the class's name and the settings that were given."""
        name = self._algorithm.__name__.lower()
        evaluation = "deterministic" if self._deterministic else "sampled"
        parameters = sum(values.numel() for values in self._model.policy.parameters())
        stored = (
            getattr(self._model, "buffer_size", None)
            or getattr(self._model, "n_steps", 0) * self._model.n_envs
        )
        about = f"Stable-Baselines3's {self._algorithm.__name__}."
        title = self._algorithm.__name__
        return Card(
            name, title, about, evaluation, self._told, stored_steps=int(stored), parameters=parameters
        )


class Sb3Factory:
    """Makes agents of one SB3 class and its settings; pickles, so that processes can have it."""

    def __init__(self, algorithm: type[BaseAlgorithm], deterministic: bool, settings: dict[str, Any]) -> None:
        self._algorithm, self._deterministic, self._settings = algorithm, deterministic, settings
        self._told = {key: as_setting(value) for key, value in settings.items()}
        self.__name__ = algorithm.__name__.lower()

    def __call__(
        self, observation_space: gym.Space[Any], action_space: gym.Space[Any], seed: int, /
    ) -> Sb3Agent:
        """An untrained agent."""
        spaces = (observation_space, action_space)
        given = (self._algorithm, spaces, seed, self._deterministic, self._settings)
        return Sb3Agent(*given, told=self._told)


def sb3(algorithm: type[BaseAlgorithm], *, deterministic: bool = True, **settings: Any) -> Factory:
    """The factory of an SB3 model of any kind: ``sb3(PPO, n_steps=250)``.

    Args:
        algorithm: ``PPO``, ``SAC`` …, of Stable-Baselines3 or built on it.
        deterministic: whether evaluation takes the policy's best action or samples.
        settings: its keyword arguments; ``policy`` is ``"MlpPolicy"`` unless given.
    """
    return Sb3Factory(algorithm, deterministic, settings)
