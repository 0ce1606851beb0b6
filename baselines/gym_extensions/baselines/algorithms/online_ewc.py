"""TRPO with online elastic weight consolidation (Kirkpatrick et al. 2017; Schwarz et al. 2018)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gym_extensions.baselines.agent import Array, Setting
from gym_extensions.baselines.algorithms.continual import STATES_PER_TASK, QuadraticTrpo
from gym_extensions.baselines.trust_region.policy import Architecture, passed


def diagonal_fisher(architecture: Architecture, theta: Array, inputs: Array) -> Array:
    """Mean over the states of Σₐ (∂μₐ/∂θᵢ)² / σₐ², and 2 for log σ; float64 (p,).

    The expectation over actions is exact, as in Wolczyk et al. 2021, appendix. ``inputs`` (n, o) are those of
    the network, n > 0.
    """
    outputs = architecture.sizes[-1]
    views, values, hidden_slopes = passed(architecture, theta, inputs)
    total = np.zeros(len(theta))
    for output in range(outputs):
        upstream = np.zeros_like(values[-1])
        upstream[:, output] = np.exp(-theta[len(theta) - outputs + output])
        if architecture.tanh_mean:
            upstream[:, output] *= 1 - np.tanh(values[-1][:, output]) ** 2
        parts: list[Array] = [np.zeros(outputs)]
        for layer in range(len(views) - 1, -1, -1):
            squares = upstream.astype(np.float64) ** 2
            parts += [squares.sum(axis=0), (np.square(values[layer], dtype=np.float64).T @ squares).ravel()]
            if layer:
                upstream = (upstream @ views[layer][0].T) * hidden_slopes[layer - 1]
        total += np.concatenate(parts[::-1])
    total /= len(inputs)
    total[-outputs:] = 2.0
    return total


class OnlineEwc(QuadraticTrpo):
    """The agent ``online-ewc``.

    The penalty is c/2 · Σᵢ ωᵢ (θᵢ − θ*ᵢ)², with θ* the parameters after the previous task and ω the decayed
    importance. After every task ω becomes γ (ω + F / mean F), with F the diagonal of the Fisher matrix over
    the task's states. Dividing by the mean gives every task the same weight, as in Schwarz et al.
    """

    name, title = "online-ewc", "TRPO + online EWC"
    description = "The reference agent with online elastic weight consolidation of the policy."
    published_coefficient = 0.1  # docs/learners.md
    states_per_task = STATES_PER_TASK
    decay = 0.95  # this project, for γ of Schwarz et al. 2018

    def _end_of_task(self, observations: Array) -> None:
        fisher = diagonal_fisher(self._architecture, self._theta, self._policy_inputs(observations))
        importance = fisher / fisher.mean()
        if self._stored:
            importance += self._stored["importance"]
        self._anchor(self.decay * importance)

    def _method_settings(self) -> Mapping[str, Setting]:
        states = {"states_per_task": self.states_per_task}
        return {"coefficient": self.coefficient, "decay": self.decay} | states


make = OnlineEwc
