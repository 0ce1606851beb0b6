"""Makes agents of Stable-Baselines3 models, for example ``sb3(PPO, n_steps=250)``."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium as gym
from stable_baselines3.common.base_class import BaseAlgorithm

from gym_extensions.baselines.adapters.sb3_agent import Callback, Options, Sb3Agent, library
from gym_extensions.baselines.agent import Factory
from gym_extensions.errors import BenchError

SET_BY_THE_RUN = ("env", "seed")
"""Keyword arguments of a model that the training loop sets."""


def check_options(options: Options) -> None:
    """Raises ``BenchError`` if a setting belongs to the training loop or a package is missing."""
    for name in SET_BY_THE_RUN:
        if name in options.settings:
            raise BenchError(
                "bad-setting",
                f"{name!r} cannot be set, because every run sets its own.",
                where="sb3()",
                hint=f"Remove {name!r}; runs=range(5) trains five seeds.",
            )
    if options.tensorboard_log and find_spec("tensorboard") is None:
        raise BenchError(
            "missing-package",
            "tensorboard_log needs the package tensorboard.",
            where="sb3()",
            hint="Install it with: pip install tensorboard",
        )


class Sb3Factory:
    """Creates agents of one SB3 class with its options. It pickles, so worker processes can use it."""

    def __init__(self, options: Options) -> None:
        check_options(options)
        self._options = options
        self.__name__ = options.name

    def __call__(
        self, observation_space: gym.Space[Any], action_space: gym.Space[Any], seed: int, /
    ) -> Sb3Agent:
        """Creates an untrained agent."""
        return Sb3Agent((observation_space, action_space), seed, self._options)


def sb3(
    algorithm: type[BaseAlgorithm],
    *,
    deterministic: bool = True,
    normalize_observations: bool = False,
    normalize_rewards: bool = False,
    callback: Callback = None,
    log_interval: int | None = None,
    tensorboard_log: str | Path = "",
    **settings: Any,
) -> Factory:
    """A factory of agents that train a Stable-Baselines3 or SBX model. It needs the extra ``sb3`` or ``sbx``.

    An interrupted run resumes after its last finished stage and writes the same files. Each stage is one
    call of the model's ``learn``, which starts its schedules and warm-up steps again, so the manifest states
    that the agent observes task boundaries. A rollout of the model, ``n_steps`` times the number of
    environments, should divide the budget: at most 2 % more steps are allowed.

    Args:
        algorithm: ``PPO``, ``SAC``, or any other class built on SB3's ``BaseAlgorithm``.
        deterministic: whether evaluation uses the policy's best action instead of a sample.
        normalize_observations: whether observations are standardized by their running mean and standard
            deviation (SB3's ``VecNormalize``). The statistics persist across stages and do not change in
            evaluation.
        normalize_rewards: whether the model's rewards are divided by the running standard deviation of the
            discounted return. The log has the rewards of the task.
        callback: SB3 callbacks, as in ``learn(callback=…)``: one, a list, or a function. They are shared by
            all runs in this process and must pickle for worker processes.
        log_interval: as in SB3's ``learn``.
        tensorboard_log: folder of TensorBoard logs, with one subfolder per run and stage. It needs the
            package ``tensorboard``.
        settings: keyword arguments of ``algorithm``; ``policy`` defaults to ``"MlpPolicy"``, and to
            ``"MlpLstmPolicy"`` for algorithms with recurrent policies.

    Returns:
        A factory for :func:`gym_extensions.baselines.train`.

    Raises:
        ModuleNotFoundError: torch or Stable-Baselines3 is not installed.
        BenchError: ``seed`` or ``env`` is set, or ``tensorboard`` is not installed.

    Example:
        >>> from stable_baselines3 import PPO
        >>> make = sb3(PPO, n_steps=250, normalize_observations=True)
    """
    return Sb3Factory(
        Options(
            algorithm,
            settings,
            deterministic=deterministic,
            normalize_observations=normalize_observations,
            normalize_rewards=normalize_rewards,
            callback=callback,
            log_interval=log_interval,
            tensorboard_log=str(tensorboard_log),
            name=algorithm.__name__.lower(),
            title=algorithm.__name__,
            description=f"{library(algorithm)[0]}'s {algorithm.__name__}.",
        )
    )
