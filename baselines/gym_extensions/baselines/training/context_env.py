"""The vector environment of ``learn``, which gives an agent the context that it asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from gym_extensions.baselines.agent import VectorEnv
from gym_extensions.baselines.context import Observes, not_requested
from gym_extensions.errors import BenchError

TASK_CALLS = ("task", "save_state")
"""Calls that show the task; the names of the arrays of a state differ between tasks."""
CALLS = (*TASK_CALLS, "np_random", "np_random_seed")
"""Calls of the project's vector environments. Other vector environments could ``step`` by a call."""


@dataclass(frozen=True)
class TrainingContext:
    """What a stage offers to agents that ask for it.

    Args:
        observes: what the agent asked for.
        group_ids: the ids of the group's tasks in training order; the trained tasks if empty.
        stage: the number of the stage, from 1.
    """

    observes: Observes = field(default_factory=Observes)
    group_ids: tuple[str, ...] = ()
    stage: int = 1


class ContextEnv(gym.vector.VectorWrapper):
    """A vector environment with the attributes of the training context.

    ``batch_steps`` and ``budget_steps`` can always be read. The other attributes raise ``BenchError`` unless
    the agent's ``observes`` has the field that they need. ``unwrapped`` is this environment, so that no
    step is taken past it.

    Args:
        env: environment i runs ``task_ids[i % len(task_ids)]``.
        task_ids: the tasks that are trained.
        budget_steps: transitions that the agent may take.
        batch_steps: the batch size of the reference agents.
        context: of the stage.
    """

    def __init__(
        self,
        env: VectorEnv,
        task_ids: Sequence[str],
        *,
        budget_steps: int,
        batch_steps: int,
        context: TrainingContext,
    ) -> None:
        super().__init__(env)
        self.batch_steps, self.budget_steps = batch_steps, budget_steps
        self._trained, self._context = tuple(task_ids), context
        self._group_ids = context.group_ids or self._trained

    @property
    def task_ids(self) -> tuple[str, ...]:
        """The ids of the tasks that are trained, in order. Needs ``task_in_training``."""
        self._require("task_in_training", "task_ids")
        return self._trained

    @property
    def env_task_ids(self) -> tuple[str, ...]:
        """The id of each environment's task. Needs ``task_in_training``."""
        self._require("task_in_training", "env_task_ids")
        return self._of_each_env()

    @property
    def env_tasks(self) -> NDArray[np.int64]:
        """The index of each environment's task in the training order of its group, (num_envs,).

        Needs ``task_in_training``.
        """
        self._require("task_in_training", "env_tasks")
        return np.array([self._group_ids.index(task) for task in self._of_each_env()], np.int64)

    @property
    def stage(self) -> int:
        """The number of the stage, from 1. Needs ``boundaries``."""
        self._require("boundaries", "stage")
        return self._context.stage

    @property
    def num_tasks(self) -> int:
        """The number of tasks in the group. Needs ``boundaries``."""
        self._require("boundaries", "num_tasks")
        return len(self._group_ids)

    @property
    def unwrapped(self) -> Any:
        """This environment."""
        return self

    @property
    def spec(self) -> Any:  # type: ignore[override]
        """The wrapped environment's, which names the task; None unless ``task_in_training`` is set."""
        return self.env.spec if self._context.observes.task_in_training else None

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Same as the wrapped environment's ``call``. ``task`` and ``save_state`` need ``task_in_training``.

        Raises:
            BenchError: the agent did not ask for the task, or another name.
        """
        if name in TASK_CALLS:
            self._require("task_in_training", f"call({name!r})")
        if name not in CALLS:
            message, hint = f"The training environments have no {name!r}.", f"Call one of {', '.join(CALLS)}."
            raise BenchError("unknown-call", message, "env.call() in learn()", hint)
        environments: Any = self.env  # VectorEnv does not declare call, but its implementations have it
        values: tuple[Any, ...] = environments.call(name, *args, **kwargs)
        return values

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Same as ``call`` without arguments."""
        return self.call(name)

    def _of_each_env(self) -> tuple[str, ...]:
        return tuple(self._trained[i % len(self._trained)] for i in range(self.num_envs))

    def _require(self, field_name: str, name: str) -> None:
        if not getattr(self._context.observes, field_name):
            raise not_requested(f"env.{name}", field_name)
