"""Makes agents of Stable-Baselines3 models, for example ``sb3(PPO, n_steps=250)``."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from gym_extensions.baselines.adapters.hyperparameters import to_manifest_value
from gym_extensions.baselines.adapters.sb3_vec_env import BatchVecEnv, SpacesVecEnv
from gym_extensions.baselines.agent import Array, Card, Context, Factory, Setting, VectorEnv
from gym_extensions.errors import BenchError


class Sb3Agent:
    """An SB3 model as an agent. Acting and learning use separate states of torch's global generator."""

    def __init__(
        self,
        algorithm: type[BaseAlgorithm],
        spaces: tuple[gym.Space[Any], gym.Space[Any]],
        seed: int,
        deterministic: bool,
        settings: dict[str, Any],
        *,
        hyperparameters: dict[str, Setting],
    ) -> None:
        self._algorithm, self._spaces, self._settings = algorithm, spaces, settings
        self._hyperparameters = hyperparameters
        self._seed, self._deterministic = seed % 2**31, deterministic
        torch.set_num_threads(1)
        self._model = self._create_model(1)
        self._learning = torch.get_rng_state()
        self._acting = torch.Generator().manual_seed(self._seed + 1).get_state()
        self._state: tuple[Array, ...] | None = None

    def _create_model(self, num_envs: int) -> BaseAlgorithm:
        # SAC and A2C write into the policy_kwargs that they receive, so dicts are copied.
        copies = {
            name: dict(value) if isinstance(value, dict) else value for name, value in self._settings.items()
        }
        arguments: dict[str, Any] = {"policy": "MlpPolicy", "device": "cpu", "seed": self._seed} | copies
        return self._algorithm(env=SpacesVecEnv(*self._spaces, num_envs), **arguments)

    def act(self, observations: Array, context: Context | None = None) -> Array:
        """Actions of the model's policy, sampled or deterministic.

        A recurrent policy keeps its state from call to call; it starts again where ``context.episode_starts``
        is True.

        Raises:
            BenchError: the policy is recurrent, and there is no context.
        """
        starts = None if context is None else context.episode_starts
        if starts is None or starts.all():
            self._state = None
        torch.set_rng_state(self._acting)
        actions, self._state = self._model.predict(
            observations, state=self._state, episode_start=starts, deterministic=self._deterministic
        )
        self._acting = torch.get_rng_state()
        if self._state is not None and context is None:
            hint = "Pass a gym_extensions.baselines.Context with the starts of the episodes."
            raise BenchError("needs-context", "The policy is recurrent.", "act()", hint)
        return np.asarray(actions)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Calls the model's ``learn``, which continues from the current parameters."""
        if self._model.n_envs != env.num_envs:
            parameters: Any = self._model.get_parameters()
            self._model = self._create_model(env.num_envs)
            self._model.set_parameters(parameters)
        torch.set_rng_state(self._learning)
        self._model.set_env(BatchVecEnv(env))
        self._model.learn(steps)
        self._learning = torch.get_rng_state()

    def card(self) -> Card:
        """The agent's description in the manifest, with the name of its class and its settings."""
        model, name = self._model, self._algorithm.__name__
        rollout_steps = getattr(model, "n_steps", 0) * model.n_envs
        return Card(
            name.lower(),
            title=name,
            description=f"Stable-Baselines3's {name}.",
            evaluation="deterministic" if self._deterministic else "sampled",
            hyperparameters=self._hyperparameters,
            stored_steps=int(getattr(model, "buffer_size", None) or rollout_steps),
            parameters=sum(values.numel() for values in model.policy.parameters()),
        )


class Sb3Factory:
    """Creates agents of one SB3 class with its settings. It pickles, so worker processes can use it."""

    def __init__(self, algorithm: type[BaseAlgorithm], deterministic: bool, settings: dict[str, Any]) -> None:
        self._algorithm, self._deterministic, self._settings = algorithm, deterministic, settings
        self._hyperparameters = {name: to_manifest_value(value) for name, value in settings.items()}
        self.__name__ = algorithm.__name__.lower()

    def __call__(
        self, observation_space: gym.Space[Any], action_space: gym.Space[Any], seed: int, /
    ) -> Sb3Agent:
        """Creates an untrained agent."""
        return Sb3Agent(
            self._algorithm,
            (observation_space, action_space),
            seed,
            self._deterministic,
            self._settings,
            hyperparameters=self._hyperparameters,
        )


def sb3(algorithm: type[BaseAlgorithm], *, deterministic: bool = True, **settings: Any) -> Factory:
    """A factory of agents that train a Stable-Baselines3 model. It needs the extra ``sb3``.

    Args:
        algorithm: ``PPO``, ``SAC``, or any other class built on SB3's ``BaseAlgorithm``.
        deterministic: whether evaluation uses the policy's best action instead of a sample.
        settings: keyword arguments of ``algorithm``; ``policy`` defaults to ``"MlpPolicy"``.

    Returns:
        A factory for :func:`gym_extensions.baselines.train`.

    Raises:
        ModuleNotFoundError: torch or Stable-Baselines3 is not installed.

    Example:
        >>> from stable_baselines3 import PPO
        >>> make = sb3(PPO, n_steps=250)
    """
    return Sb3Factory(algorithm, deterministic, settings)
