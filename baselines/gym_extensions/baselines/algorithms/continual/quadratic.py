"""A quadratic penalty on the distance of the parameters from an anchor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array, Setting
from gym_extensions.baselines.algorithms.continual.regularizer import Inputs
from gym_extensions.baselines.trpo.gaussian_policy import Architecture
from gym_extensions.baselines.trpo.optimize import dot
from gym_extensions.baselines.trpo.penalty import Curvature


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
