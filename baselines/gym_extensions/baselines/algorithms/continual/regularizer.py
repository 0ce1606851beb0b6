"""What a regularization method adds to an agent: a penalty during a task, and what it stores after a task."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from gym_extensions.baselines.agent import Array, Setting
from gym_extensions.baselines.trpo.gaussian_policy import Architecture
from gym_extensions.baselines.trpo.penalty import Penalty

Inputs = Callable[[Array], Array]
"""Maps raw observations (n, o) to the inputs of the policy network, by the present moments."""


class Regularizer(Protocol):
    """A method of continual learning as a penalty on the policy's parameters."""

    states_per_task: int
    """Observations of the task that ``end_of_task`` needs."""
    state: dict[str, Array]
    """Everything that it stores, by name."""

    def start(self, theta: Array) -> None:
        """Receives the initial parameters (p,)."""

    def penalty(self, architecture: Architecture, inputs: Inputs) -> Penalty | None:
        """The penalty of the next update, or None if there is none."""

    def end_of_task(
        self, architecture: Architecture, theta: Array, observations: Array, inputs: Inputs
    ) -> None:
        """Stores what later tasks need.

        Args:
            architecture: the policy's network.
            theta: the parameters at the end of the task (p,).
            observations: at most ``states_per_task`` raw observations of the task (n, o).
            inputs: maps them to the network's inputs.
        """

    @property
    def stored_states(self) -> int:
        """Number of observations that it stores between tasks."""

    @property
    def settings(self) -> Mapping[str, Setting]:
        """Its hyperparameters."""
