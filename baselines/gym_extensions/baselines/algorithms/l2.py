"""TRPO with an L2 penalty on the distance from the weights after the previous task, or the initial ones."""

from __future__ import annotations

from gym_extensions.baselines.agent import Array, Observes
from gym_extensions.baselines.algorithms.continual import (
    Inputs,
    QuadraticRegularizer,
    RegularizedTrpo,
    Regularizer,
)
from gym_extensions.baselines.trpo.policy import Architecture


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
    published_coefficient = 0.1  # docs/learners.md

    def _new_regularizer(self, coefficient: float) -> Regularizer:
        return PreviousTask(coefficient)


class InitialWeights(QuadraticRegularizer):
    """c/2 · Σᵢ (θᵢ − θ⁰ᵢ)², with θ⁰ the initial parameters, from the first task on."""

    def start(self, theta: Array) -> None:
        """Anchors the parameters."""
        self._anchor(theta)


class L2Init(RegularizedTrpo):
    """The agent ``l2-init``, which does not use the boundaries of tasks."""

    name, title = "l2-init", "TRPO + L2 Init"
    description = "The reference agent with an L2 penalty to the policy's initial weights."
    parent = ""
    observes = Observes()
    published_coefficient = 0.01  # docs/learners.md

    def _new_regularizer(self, coefficient: float) -> Regularizer:
        return InitialWeights(coefficient)


make = L2
