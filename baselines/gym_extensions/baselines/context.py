"""What an agent observes besides observations and rewards: how it asks, and what it is given."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError


@dataclass(frozen=True)
class Observes:
    """What an agent asks for besides observations and rewards, in its attribute ``observes``.

    The section ``[observes]`` of a submission's manifest is written from it.

    Args:
        task_in_training: the tasks that are trained, in ``learn``.
        task_in_evaluation: the task that is evaluated, in ``act``. Such entries have separate boards.
        boundaries: the number of the stage and the number of tasks, in ``learn``. An agent whose later calls
            of ``learn`` do something else than its first one, such as a penalty on forgetting, needs it too.

    Example:
        >>> Observes(task_in_training=True, boundaries=True)
        Observes(task_in_training=True, task_in_evaluation=False, boundaries=True)
    """

    task_in_training: bool = False
    task_in_evaluation: bool = False
    boundaries: bool = False


class NotRequestedError(BenchError, AttributeError):
    """An agent reads what it did not ask for.

    It is also an ``AttributeError``, so that ``hasattr`` is False and ``getattr`` returns its default.
    """

    def __init__(self, code: str, message: str, where: str = "", hint: str = "") -> None:
        BenchError.__init__(self, code, message, where, hint)


def not_requested(name: str, field_name: str) -> NotRequestedError:
    """The error of an attribute that needs a field of :class:`Observes` that is not set."""
    message = f"The agent did not ask for it in its attribute observes.{field_name}."
    hint = f"Give the agent's class the attribute observes = Observes({field_name}=True)."
    return NotRequestedError("not-requested", message, name, hint)


@dataclass(frozen=True)
class TaskLabel:
    """A task's id and its index in the training order of its group."""

    id: str
    index: int


@dataclass(frozen=True)
class Context:
    """What the method ``act(observations, context)`` of an agent is given in evaluation.

    Args:
        episode_starts: (num_envs,) booleans, True where the observation is the first one of an episode. All
            are True in the first call of an evaluation.
        label: the evaluated task; None unless the agent asked for it.

    Example:
        >>> context = Context(np.array([True, False]), TaskLabel("gym_extensions/Hopper-v0", 2))
        >>> context.task_id, context.task
        ('gym_extensions/Hopper-v0', 2)
    """

    episode_starts: NDArray[np.bool_]
    label: TaskLabel | None = field(default=None, repr=False)

    @property
    def task_id(self) -> str:
        """The id of the evaluated task. Raises ``BenchError`` unless the agent asked for it."""
        if self.label is None:
            raise not_requested("context.task_id", "task_in_evaluation")
        return self.label.id

    @property
    def task(self) -> int:
        """The task's index in the training order of its group; raises as ``task_id`` does."""
        if self.label is None:
            raise not_requested("context.task", "task_in_evaluation")
        return self.label.index
