"""TRPO with an L2 penalty on the distance from the weights after the previous task (Wolczyk et al. 2021)."""

from __future__ import annotations

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.algorithms.continual import settings as table
from gym_extensions.baselines.algorithms.continual.quadratic import QuadraticRegularizer
from gym_extensions.baselines.algorithms.continual.regularized import RegularizedTrpo
from gym_extensions.baselines.algorithms.continual.regularizer import Inputs, Regularizer
from gym_extensions.baselines.trpo.gaussian_policy import Architecture


class PreviousTask(QuadraticRegularizer):
    """c/2 · Σᵢ (θᵢ − θ*ᵢ)², with θ* the parameters after the previous task."""

    def end_of_task(
        self, architecture: Architecture, theta: Array, observations: Array, inputs: Inputs
    ) -> None:
        """Anchors the parameters."""
        self._anchor(theta)


class L2(RegularizedTrpo):
    """The agent ``l2``."""

    name, title = "l2", "TRPO + L2"
    description = "The reference agent with an L2 penalty to the policy's weights after the previous task."
    published_coefficient = table.L2

    def _new_regularizer(self, coefficient: float) -> Regularizer:
        return PreviousTask(coefficient)


make = L2
