"""A Stable-Baselines3 model as an agent that can be saved."""

from __future__ import annotations

import copy
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from gym_extensions.baselines.adapters.sb3_policy import exported
from gym_extensions.baselines.adapters.sb3_state import (
    Generators,
    Normalization,
    PolicyKeys,
    from_arrays,
    model_state,
    num_parameters,
    restore_model,
    stored_steps,
    to_arrays,
)
from gym_extensions.baselines.adapters.sb3_vec_env import BatchVecEnv, SpacesVecEnv
from gym_extensions.baselines.agent import (
    Array,
    Card,
    Context,
    Observes,
    Setting,
    VectorEnv,
    load_arrays,
    save_arrays,
)
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.manifest import LONG, hyperparameter_error
from gym_extensions.rollouts.run_policies import AnyPolicy

Callback = BaseCallback | list[BaseCallback] | Callable[[dict[str, Any], dict[str, Any]], bool] | None
"""What SB3's ``learn(callback=…)`` accepts."""
ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


def to_manifest_value(value: Any) -> Setting:
    """A plain value unchanged (a tuple as a list), any other value as text, cut at the manifest's limit.

    The text of a class or function is its qualified name, so two lambdas of one scope have the same text. The
    text contains no module name and no memory address: it is the same in every process.
    """
    if not hyperparameter_error(value):
        plain: Setting = list(value) if isinstance(value, tuple) else value
        return plain
    return _text(value)[:LONG]


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray | np.generic):
        return _text(value.tolist())
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_text(key)}: {_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_text, value)) + "]"
    if isinstance(value, set | frozenset):
        return "{" + ", ".join(sorted(map(_text, value))) + "}"
    kind: Any = type(value)
    if hasattr(value, "__qualname__"):
        return str(value.__qualname__)
    return str(kind.__qualname__) if kind.__repr__ is object.__repr__ else ADDRESS.sub("", repr(value))


ModelSettings = Mapping[str, Any]
NOT_HYPERPARAMETERS = ("device", "verbose")
"""Keyword arguments of a model that are not stored in the manifest, because they do not change a result."""

LIBRARIES: dict[str, tuple[str, tuple[str, ...]]] = {
    "stable_baselines3": ("Stable-Baselines3", ()),
    "sb3_contrib": ("SB3-Contrib", ("sb3-contrib",)),
    "sbx": ("SBX", ("sbx-rl", "jax", "jaxlib", "flax", "optax")),
}
"""By the name of a library's module, its name and its packages besides those of Stable-Baselines3."""


def library(algorithm: type[BaseAlgorithm]) -> tuple[str, tuple[str, ...]]:
    """The row of ``LIBRARIES`` of a class; that of Stable-Baselines3 for a class of the user."""
    return LIBRARIES.get(algorithm.__module__.partition(".")[0], LIBRARIES["stable_baselines3"])


def no_batch_settings(num_envs: int, batch_steps: int) -> ModelSettings:
    """No settings that depend on the environments or the batch."""
    return {}


@dataclass(frozen=True)
class Options:
    """How an agent creates, trains and evaluates its model. See :func:`gym_extensions.baselines.sb3`.

    Args:
        algorithm: the model's class.
        settings: keyword arguments of the class.
        deterministic: whether evaluation uses the policy's best action instead of a sample.
        normalize_observations: whether observations are standardized by running statistics.
        normalize_rewards: whether the model's rewards are scaled by running statistics.
        callback: SB3 callbacks of ``learn``.
        log_interval: SB3's ``log_interval``; the model's default if None.
        tensorboard_log: folder of TensorBoard logs; none if empty.
        continue_counting: whether a stage continues the model's count of steps, so that warm-up steps and
            schedules do not start again. An agent that does not use task boundaries continues.
        fresh_buffer: whether the replay buffer is emptied at the start of a stage.
        batch_settings: further settings from the number of environments and the budget's batch size.
        tuning_steps, tuning_tasks, parent: as in :class:`gym_extensions.baselines.Card`.
        name, title, description: of the agent; the class's if empty.
        hyperparameters: rows of the manifest besides ``settings``, such as those of ``batch_settings``.
    """

    algorithm: type[BaseAlgorithm]
    settings: ModelSettings = field(default_factory=dict)
    deterministic: bool = True
    normalize_observations: bool = False
    normalize_rewards: bool = False
    callback: Callback = None
    log_interval: int | None = None
    tensorboard_log: str = ""
    continue_counting: bool = False
    fresh_buffer: bool = False
    batch_settings: Callable[[int, int], ModelSettings] = no_batch_settings
    tuning_steps: int = 0
    tuning_tasks: tuple[str, ...] = ()
    parent: str = ""
    name: str = ""
    title: str = ""
    description: str = ""
    hyperparameters: Mapping[str, Setting] = field(default_factory=dict)

    @property
    def packages(self) -> tuple[str, ...]:
        """The packages that the model's results depend on."""
        return ("stable-baselines3", "torch", *library(self.algorithm)[1])

    def learn_arguments(self, run_name: str) -> dict[str, Any]:
        """Keyword arguments of the model's ``learn``, without the callback."""
        arguments: dict[str, Any] = {"reset_num_timesteps": not self.continue_counting}
        if self.log_interval is not None:
            arguments["log_interval"] = self.log_interval
        return arguments | ({"tb_log_name": run_name} if self.tensorboard_log else {})

    def manifest_settings(self) -> dict[str, Setting]:
        """The hyperparameters as the manifest stores them; the normalizations only if they are used."""
        normalizations = {
            name: True for name in ("normalize_observations", "normalize_rewards") if getattr(self, name)
        }
        rows = {
            name: to_manifest_value(value)
            for name, value in self.settings.items()
            if name not in NOT_HYPERPARAMETERS
        }
        return rows | dict(self.hyperparameters) | normalizations


PLACEHOLDER = (1, 2_000)
"""Environments and batch size, of the budget ``100k``, of a model before its first training."""


class Sb3Agent:
    """An SB3 model as an agent. Acting and learning use separate states of the global random generators.

    The model is created again if the number of environments or the batch size changes before training starts.
    """

    def __init__(self, spaces: tuple[gym.Space[Any], gym.Space[Any]], seed: int, options: Options) -> None:
        # A model seeds its action space, so it has a copy.
        self._spaces, self._options = copy.deepcopy(spaces), options
        self._seed, self._trained = seed % 2**31, False
        torch.set_num_threads(1)
        self._learning, self._acting = Generators(self._seed), Generators(self._seed + 1)
        self._normalization = Normalization(options.normalize_observations, options.normalize_rewards)
        self._size = (0, 0)
        self._state: tuple[Array, ...] | None = None
        self.observes = Observes(boundaries=options.fresh_buffer or not options.continue_counting)
        self._model = self._create_model(*PLACEHOLDER)
        self._keys = PolicyKeys(self._model.policy, self._seed + 1)

    def _create_model(self, num_envs: int, batch_steps: int) -> BaseAlgorithm:
        self._size = (num_envs, batch_steps)
        options = self._options
        # SAC and A2C write into the policy_kwargs that they receive, so dicts are copied.
        copies = {
            name: dict(value) if isinstance(value, dict) else value
            for name, value in {**options.settings, **options.batch_settings(num_envs, batch_steps)}.items()
        }
        if options.tensorboard_log:
            copies["tensorboard_log"] = options.tensorboard_log
        policy = "MlpPolicy" if "MlpPolicy" in options.algorithm.policy_aliases else "MlpLstmPolicy"
        arguments: dict[str, Any] = {"policy": policy, "device": "cpu", "seed": self._seed} | copies
        env = SpacesVecEnv(*self._spaces, num_envs)
        self._learning = Generators(self._seed)
        with self._learning.active(), warnings.catch_warnings():
            # The number of environments is not final, and a smaller last minibatch is allowed.
            warnings.filterwarnings("ignore", "You have specified a mini-batch size")
            model = options.algorithm(env=env, **arguments)
        self._normalization.wrap(env, getattr(model, "gamma", 1.0))
        return model

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
        seen = self._normalization.normalize(np.asarray(observations, self._model.observation_space.dtype))
        with self._acting.active(), self._keys.active(self._model.policy):
            actions, self._state = self._model.predict(
                seen, state=self._state, episode_start=starts, deterministic=self._options.deterministic
            )
        if self._state is not None and context is None:
            hint = "Pass a gym_extensions.baselines.Context with the starts of the episodes."
            raise BenchError("needs-context", "The policy is recurrent.", "act()", hint)
        return np.asarray(actions)

    def policy(self) -> AnyPolicy | None:
        """The policy as plain arrays or as a network; None, with a warning, if it is neither."""
        try:
            return exported(
                self._model,
                deterministic=self._options.deterministic,
                statistics=self._normalization.observation_statistics(),
                observation_shape=self._spaces[0].shape,
            )
        except BenchError as error:
            message = f"The policy is not stored, so that the entry stays claimed. {error}"
            warnings.warn(message, stacklevel=2)
            return None

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Calls the model's ``learn``, which continues from the current state.

        Raises:
            BenchError: the number of environments changed after training started.
        """
        self._fit_model_to(env.num_envs, int(getattr(env, "batch_steps", PLACEHOLDER[1])))
        model, options = self._model, self._options
        if options.fresh_buffer:
            buffer: Any = model.replay_buffer  # type: ignore[attr-defined]
            buffer.reset()
        wrapped = self._normalization.wrap(BatchVecEnv(env), getattr(model, "gamma", 1.0))
        self._trained = True
        with self._learning.active():
            model.set_env(wrapped)
            model.learn(
                steps,
                callback=options.callback,
                **options.learn_arguments(f"{options.name}-seed{self._seed}"),
            )

    def _fit_model_to(self, num_envs: int, batch_steps: int) -> None:
        if self._size == (num_envs, batch_steps):
            return
        if self._trained:
            raise BenchError(
                "other-environments",
                f"The model was trained with {self._size[0]} environments and batches of {self._size[1]} "
                f"steps, not {num_envs} and {batch_steps}.",
                where="learn()",
                hint="Train all stages of a run with the same number of environments and the same budget.",
            )
        self._model = self._create_model(num_envs, batch_steps)

    def card(self) -> Card:
        """The agent's description in the manifest, with the name of its class and its settings."""
        model, options = self._model, self._options
        return Card(
            options.name,
            title=options.title,
            description=options.description,
            evaluation="deterministic" if options.deterministic else "sampled",
            hyperparameters=options.manifest_settings(),
            tuning_steps=options.tuning_steps,
            tuning_tasks=options.tuning_tasks,
            stored_steps=stored_steps(model),
            parameters=num_parameters(model),
            packages=options.packages,
            parent=options.parent,
        )

    def save(self, path: Path) -> None:
        """Writes networks, optimizers, replay buffer, statistics and random generators, without pickle."""
        state = {
            "size": list(self._size),
            "trained": self._trained,
            "model": model_state(self._model),
            "normalization": self._normalization.state(),
            "learning": self._learning.state,
            "acting": self._acting.state,
            "keys": self._keys.state(),
            "action_space": self._spaces[1].np_random.bit_generator.state,
        }
        save_arrays(path, **to_arrays(state))

    def load(self, path: Path) -> None:
        """Restores a saved agent.

        Raises:
            BenchError: the file belongs to a model with other settings, or is not a checkpoint.
        """
        try:
            state = from_arrays(load_arrays(path))
            self._model = self._create_model(*state["size"])
            restore_model(self._model, state["model"])
            self._normalization.restore(state["normalization"])
            self._learning.state, self._acting.state = state["learning"], state["acting"]
            self._keys.restore(state["keys"])
            self._spaces[1].np_random.bit_generator.state = state["action_space"]
            self._trained = state["trained"]
        except (KeyError, ValueError, RuntimeError) as error:
            raise BenchError(
                "bad-checkpoint",
                f"The checkpoint does not fit this {self._options.title}: {error}",
                where=str(path),
                hint="Repeat the command with the settings and versions of the run, or delete its folder.",
            ) from error
