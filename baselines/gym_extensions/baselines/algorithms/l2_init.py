"""TRPO with an L2 penalty on the distance from the initial weights (Kumar, Marklund and Van Roy 2023)."""

from __future__ import annotations

from gym_extensions.baselines.agent import Array, Observes
from gym_extensions.baselines.algorithms.continual import settings as table
from gym_extensions.baselines.algorithms.continual.quadratic import QuadraticRegularizer
from gym_extensions.baselines.algorithms.continual.regularized import RegularizedTrpo
from gym_extensions.baselines.algorithms.continual.regularizer import Regularizer


class InitialWeights(QuadraticRegularizer):
    """c/2 · Σᵢ (θᵢ − θ⁰ᵢ)², with θ⁰ the initial parameters, from the first task on."""

    def start(self, theta: Array) -> None:
        """Anchors the parameters."""
        self._anchor(theta)


class L2Init(RegularizedTrpo):
    """The agent ``l2-init``, which does not use the boundaries of tasks."""

    name, title = "l2-init", "TRPO + L2 Init"
    description = "The reference agent with an L2 penalty to the policy's initial weights."
    observes = Observes()
    published_coefficient = table.L2_INIT

    def _new_regularizer(self, coefficient: float) -> Regularizer:
        return InitialWeights(coefficient)


make = L2Init
