"""The options of an agent of Stable-Baselines3, checked before anything is trained."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm

from gym_extensions.baselines.adapters.hyperparameters import to_manifest_value
from gym_extensions.baselines.adapters.sb3_callback import Callback
from gym_extensions.baselines.agent import Setting
from gym_extensions.errors import BenchError

ModelSettings = Mapping[str, Any]
SET_BY_THE_RUN = ("env", "seed")
"""Keyword arguments of a model that the training loop sets."""
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
        tuning_steps, tuning_tasks: as in :class:`gym_extensions.baselines.Card`.
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
