"""What the methods with a penalty add to trpo: a regularizer, and a sample of each task's states.

No penalty depends on the scale of rewards or observations. Its coefficient is the same for all groups;
docs/learners.md has the measurements.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, Observes, Setting, VectorEnv
from gym_extensions.baselines.algorithms.trpo import (
    REFERENCE,
    TUNING_STEPS,
    TUNING_TASKS,
    Trpo,
    TrpoSettings,
)
from gym_extensions.baselines.trpo.policy import Architecture
from gym_extensions.baselines.trpo.update import Curvature, Penalty, dot
from gym_extensions.baselines.trpo.values import Transitions

Inputs = Callable[[Array], Array]
"""Maps raw observations (n, o) to the inputs of the policy network, by the present moments."""
STATES_PER_TASK = 1_000  # this project; the code of Wolczyk et al. 2021 uses 2,560 for EWC


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


class StateSample:
    """Every k-th observation of the last half of a task, at most ``size`` of them.

    The last half is many episodes long, also where all environments reset together, and its states are near
    those of the final policy. No random number is drawn. k is odd, so that it is not a multiple of an even
    number of environments.

    Args:
        size: observations to sample.
        steps: transitions of the task.
    """

    def __init__(self, size: int, steps: int) -> None:
        self._size, self._start, self._seen = size, steps // 2, 0
        stride = max(1, (steps - self._start) // max(size, 1))
        self._stride = stride - 1 if stride > 1 and stride % 2 == 0 else stride
        self._parts: list[Array] = []

    def add(self, observations: Array) -> None:
        """Samples from the next observations (n, o) of the task."""
        rows = np.arange(self._seen, self._seen + len(observations)) - self._start
        self._seen += len(observations)
        chosen = (rows >= 0) & (rows % self._stride == 0) & (rows < self._size * self._stride)
        self._parts.append(observations[chosen])

    @property
    def observations(self) -> Array:
        """The sample (n, o)."""
        return np.concatenate(self._parts)


@dataclass(frozen=True)
class Quadratic:
    """c/2 · Σᵢ ωᵢ (θᵢ − θ*ᵢ)², with coefficient c, importance ω (p,) and anchor θ* (p,).

    Example:
        >>> Quadratic(0.5, np.ones(2), np.array([1.0, 3.0])).value(np.array([2.0, 3.0]))
        0.25
    """

    coefficient: float
    importance: Array
    anchor: Array

    def value(self, theta: Array) -> float:
        """The penalty."""
        gap = theta - self.anchor
        return 0.5 * self.coefficient * dot(self.importance, gap * gap)

    def gradient(self, theta: Array) -> Array:
        """c ω (θ − θ*), of shape (p,)."""
        slope: Array = self._diagonal() * (theta - self.anchor)
        return slope

    def curvature(self, theta: Array) -> Curvature:
        """c diag(ω), exact."""
        diagonal = self._diagonal()
        return Curvature(lambda vector: diagonal * vector, diagonal)

    def _diagonal(self) -> Array:
        diagonal: Array = self.anchor.dtype.type(self.coefficient) * self.importance
        return diagonal


class QuadraticRegularizer:
    """A regularizer with a :class:`Quadratic` penalty; a subclass chooses the anchor and the importance."""

    states_per_task = 0

    def __init__(self, coefficient: float) -> None:
        self.coefficient = coefficient
        self.state: dict[str, Array] = {"anchor": np.zeros(0), "importance": np.zeros(0)}

    def start(self, theta: Array) -> None:
        """Nothing is anchored before the first task."""

    def end_of_task(
        self, architecture: Architecture, theta: Array, observations: Array, inputs: Inputs
    ) -> None:
        """Nothing changes at the end of a task."""

    def penalty(self, architecture: Architecture, inputs: Inputs) -> Quadratic | None:
        """The penalty, or None while nothing is anchored or if the coefficient is 0."""
        if not (self.coefficient and self.state["anchor"].size):
            return None
        return Quadratic(self.coefficient, self.state["importance"], self.state["anchor"])

    @property
    def stored_states(self) -> int:
        """No observation is stored between tasks."""
        return 0

    @property
    def settings(self) -> Mapping[str, Setting]:
        """The coefficient."""
        return {"coefficient": self.coefficient}

    def _anchor(self, theta: Array, importance: Array | None = None) -> None:
        weights = np.ones_like(theta) if importance is None else importance.astype(theta.dtype)
        self.state = {"anchor": theta.copy(), "importance": weights}


class RegularizedTrpo(Trpo):
    """The reference agent with a penalty on its policy's parameters. The value function has no penalty."""

    observes = Observes(boundaries=True)
    tuning_steps = TUNING_STEPS + 2_000_000  # docs/learners.md
    tuning_tasks = (*TUNING_TASKS, "HalfCheetah at 0.6, 0.9 and 1.4 gravity")
    parent = Trpo.name
    published_coefficient: float
    """The coefficient of the penalty for all groups."""

    def __init__(
        self,
        observation_space: gym.spaces.Box,
        action_space: gym.spaces.Box,
        seed: int,
        settings: TrpoSettings = REFERENCE,
        coefficient: float | None = None,
    ) -> None:
        super().__init__(observation_space, action_space, seed, settings)
        strength = self.published_coefficient if coefficient is None else coefficient
        self._regularizer = self._new_regularizer(strength)
        self._regularizer.start(self._theta)
        self._sample_of_task = StateSample(0, 0)
        self._most_stored = 0

    @abstractmethod
    def _new_regularizer(self, coefficient: float) -> Regularizer:
        """The method's regularizer."""

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Learns one stage, and then stores what the penalty of later stages needs."""
        regularizer = self._regularizer
        self._sample_of_task = StateSample(regularizer.states_per_task, steps)
        super().learn(env, steps)
        observations = self._sample_of_task.observations
        held = len(observations) + regularizer.stored_states
        regularizer.end_of_task(self._architecture, self._theta, observations, self._policy_inputs)
        self._most_stored = max(self._most_stored, held)
        self._sample_of_task = StateSample(0, 0)

    def _update(self, transitions: Transitions) -> None:
        super()._update(transitions)
        self._sample_of_task.add(self._observations_of(transitions))

    def _penalty(self) -> Penalty | None:
        return self._regularizer.penalty(self._architecture, self._policy_inputs)

    def card(self) -> Card:
        """The card of ``trpo`` with the hyperparameters and the stored states of the method."""
        card = super().card()
        settings = {**card.hyperparameters, **self._regularizer.settings}
        return replace(card, hyperparameters=settings, stored_steps=card.stored_steps + self._most_stored)

    def _state(self) -> dict[str, Array]:
        stored = {f"regularizer_{name}": values for name, values in self._regularizer.state.items()}
        return super()._state() | stored | {"most_stored": np.array(self._most_stored)}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        regularizer = self._regularizer
        regularizer.state = {name: arrays[f"regularizer_{name}"] for name in regularizer.state}
        self._most_stored = int(arrays["most_stored"])
