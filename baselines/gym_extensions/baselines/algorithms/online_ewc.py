"""TRPO with online elastic weight consolidation (Kirkpatrick et al. 2017; Schwarz et al. 2018)."""

from __future__ import annotations

from collections.abc import Mapping

from gym_extensions.baselines.agent import Array, Setting
from gym_extensions.baselines.algorithms.continual import settings as table
from gym_extensions.baselines.algorithms.continual.fisher import diagonal_fisher
from gym_extensions.baselines.algorithms.continual.quadratic import QuadraticRegularizer
from gym_extensions.baselines.algorithms.continual.regularized import RegularizedTrpo
from gym_extensions.baselines.algorithms.continual.regularizer import Inputs, Regularizer
from gym_extensions.baselines.trpo.gaussian_policy import Architecture


class OnlineEwc(QuadraticRegularizer):
    """c/2 · Σᵢ ωᵢ (θᵢ − θ*ᵢ)², with θ* the parameters after the previous task and ω the decayed importance.

    After every task ω becomes γ (ω + F / mean F), with F the diagonal of the Fisher matrix over the task's
    states. Dividing by the mean gives every task the same weight, as in Schwarz et al.
    """

    def __init__(self, coefficient: float, decay: float, states_per_task: int) -> None:
        super().__init__(coefficient)
        self.decay, self.states_per_task = decay, states_per_task

    def end_of_task(
        self, architecture: Architecture, theta: Array, observations: Array, inputs: Inputs
    ) -> None:
        """Adds the task's importance and anchors the parameters."""
        fisher = diagonal_fisher(architecture, theta, inputs(observations))
        importance = fisher / fisher.mean()
        if self.state["importance"].size:
            importance += self.state["importance"]
        self._anchor(theta, self.decay * importance)

    @property
    def settings(self) -> Mapping[str, Setting]:
        """The coefficient, the decay and the observations per task."""
        return {**super().settings, "decay": self.decay, "states_per_task": self.states_per_task}


class OnlineEwcTrpo(RegularizedTrpo):
    """The agent ``online-ewc``."""

    name, title = "online-ewc", "TRPO + online EWC"
    description = "The reference agent with online elastic weight consolidation of the policy."
    published_coefficient = table.EWC

    def _new_regularizer(self, coefficient: float) -> Regularizer:
        return OnlineEwc(coefficient, table.EWC_DECAY, table.STATES_PER_TASK)


make = OnlineEwcTrpo
