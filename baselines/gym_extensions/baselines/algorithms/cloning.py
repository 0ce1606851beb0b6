"""TRPO that clones its earlier policies on stored states (Rusu et al. 2016; Wolczyk et al. 2022)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.algorithms.continual import STATES_PER_TASK, RegularizedTrpo
from gym_extensions.baselines.trust_region.policy import (
    Architecture,
    fisher_product,
    gradient,
    mean_and_log_sigma,
    passed,
)
from gym_extensions.baselines.trust_region.update import Curvature


@dataclass(frozen=True)
class Divergence:
    """c · mean KL(old ‖ new) over stored states, in nats, summed over the action's components."""

    coefficient: float  # c
    architecture: Architecture  # of the policy
    inputs: Array  # of the network at the stored states (n, o)
    means: Array  # of the old policies at these states (n, a)
    log_sigmas: Array  # of the old policies (n, a)

    def value(self, theta: Array) -> float:
        mean, log_sigma = mean_and_log_sigma(self.architecture, theta, self.inputs)
        spread = (np.exp(2 * self.log_sigmas) + (mean - self.means) ** 2) * np.exp(-2 * log_sigma)
        terms = log_sigma - self.log_sigmas + 0.5 * spread - 0.5
        return self.coefficient * float(np.sum(terms, dtype=np.float64)) / len(terms)

    def gradient(self, theta: Array) -> Array:
        """Its gradient (p,): (μ − μ_old) / σ² over the means, 1 − (σ_old² + (μ − μ_old)²) / σ² over log σ."""
        views, values, hidden_slopes = passed(self.architecture, theta, self.inputs)
        tanh_mean = self.architecture.tanh_mean
        mean = np.tanh(values[-1]) if tanh_mean else values[-1]
        precision = np.exp(-2 * theta[-self.architecture.sizes[-1] :])
        gap = mean - self.means
        upstream = gap * precision / len(gap)
        if tanh_mean:
            upstream = upstream * (1 - mean * mean)
        sigma_part = np.mean(1 - (np.exp(2 * self.log_sigmas) + gap * gap) * precision, axis=0)
        whole = np.concatenate([gradient(views, values, hidden_slopes, upstream), sigma_part])
        return theta.dtype.type(self.coefficient) * whole

    def curvature(self, theta: Array) -> Curvature:
        """c times the Fisher matrix over the stored states, the second derivative where new = old."""
        product = fisher_product(self.architecture, theta, self.inputs, damping=0.0)
        coefficient = theta.dtype.type(self.coefficient)
        return Curvature(lambda vector: coefficient * product(vector))


class Cloning(RegularizedTrpo):
    """The agent ``cloning``: the policy is held to what earlier policies did in the states of their tasks.

    The observations are stored raw, with the old means and log σ. So a state keeps its target when the
    moments of the observations change.
    """

    name, title = "cloning", "TRPO + behavioral cloning"
    description = "The reference agent with a penalty on KL(old ‖ new policy) in stored states of each task."
    published_coefficient = 0.1  # docs/learners.md
    states_per_task = STATES_PER_TASK

    def _penalty(self) -> Divergence | None:
        """None while no state is stored or if the coefficient is 0."""
        if not (self.coefficient and self._stored):
            return None
        inputs = self._policy_inputs(self._stored["observations"])
        targets = (self._stored["means"], self._stored["log_sigmas"])
        return Divergence(self.coefficient, self._architecture, inputs, *targets)

    def _end_of_task(self, observations: Array) -> None:
        inputs = self._policy_inputs(observations)
        means, log_sigma = mean_and_log_sigma(self._architecture, self._theta, inputs)
        log_sigmas = np.broadcast_to(log_sigma, means.shape)
        new = {"observations": observations, "means": means, "log_sigmas": log_sigmas}
        self._stored = {
            name: np.concatenate([self._stored[name], part]) if self._stored else np.array(part)
            for name, part in new.items()
        }


make = Cloning
