"""Methods that add a penalty to trpo: ``l2``, ``l2-init``, ``online-ewc`` and ``cloning``.

No penalty depends on the scale of rewards or observations. Its coefficient is the same for all groups;
docs/learners.md has the measurements.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Array, Card, Setting, VectorEnv
from gym_extensions.baselines.algorithms.trpo import TUNING_STEPS, TUNING_TASKS, Trpo
from gym_extensions.baselines.trust_region import policy as policies, update
from gym_extensions.baselines.trust_region.values import Transitions
from gym_extensions.submissions.manifest import Observes

STATES_PER_TASK = 1_000  # this project; the code of Wolczyk et al. 2021 uses 2,560 for EWC


class StateSample:
    """Every k-th observation of the last half of a task, at most ``size`` of them.

    The last half is many episodes long, also where all environments reset together, and its states are near
    those of the final policy. No random number is drawn. k is odd, so that it is not a multiple of an even
    number of environments. The task has ``steps`` transitions, of which ``seen`` were added.
    """

    def __init__(self, size: int, steps: int) -> None:
        self._size, self._start, self.seen = size, steps // 2, 0
        stride = max(1, (steps - self._start) // max(size, 1))
        self._stride = stride if stride % 2 else stride - 1
        self._parts: list[Array] = []

    def add(self, observations: Array) -> None:
        """Samples from the next observations (n, o) of the task."""
        rows = np.arange(self.seen, self.seen + len(observations)) - self._start
        self.seen += len(observations)
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
        gap = theta - self.anchor
        return 0.5 * self.coefficient * update.dot(self.importance, gap * gap)

    def gradient(self, theta: Array) -> Array:
        """c ω (θ − θ*), of shape (p,)."""
        return self._diagonal() * (theta - self.anchor)

    def curvature(self, theta: Array) -> update.Curvature:
        """c diag(ω), exact."""
        diagonal = self._diagonal()
        return update.Curvature(lambda vector: diagonal * vector, diagonal)

    def _diagonal(self) -> Array:
        return self.anchor.dtype.type(self.coefficient) * self.importance


class RegularizedTrpo(Trpo):
    """The reference agent with a penalty on its policy's parameters. The value function has no penalty.

    A method overrides ``_penalty`` and, if it stores something at the end of a task, ``_end_of_task``. One
    whose coefficient was not tuned as docs/learners.md says overrides ``tuning_steps`` and ``tuning_tasks``.
    """

    observes = Observes(boundaries=True)
    tuning_steps = TUNING_STEPS + 2_000_000  # docs/learners.md
    tuning_tasks = (*TUNING_TASKS, "HalfCheetah at 0.6, 0.9 and 1.4 gravity")
    parent = Trpo.name
    published_coefficient: float
    """The coefficient of the penalty for all groups."""
    states_per_task = 0
    """Observations of the task that ``_end_of_task`` needs."""

    def __init__(self, *arguments: Any, coefficient: float | None = None, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.coefficient = self.published_coefficient if coefficient is None else coefficient
        self._stored: dict[str, Array] = {}
        self._most_stored = 0

    def _end_of_task(self, observations: Array) -> None:
        """Stores what the penalty of later tasks needs, from observations (n, o) of the task."""

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Learns one stage, and then stores what the penalty of later stages needs."""
        self._sample = StateSample(self.states_per_task, steps)
        super().learn(env, steps)
        held = len(self._sample.observations) + len(self._stored.get("observations", ()))
        self._most_stored = max(self._most_stored, held)
        self._end_of_task(self._sample.observations)

    def _update(self, transitions: Transitions) -> None:
        super()._update(transitions)
        self._sample.add(self._observations_of(transitions))

    def _method_settings(self) -> Mapping[str, Setting]:
        states = {"states_per_task": self.states_per_task} if self.states_per_task else {}
        return {"coefficient": self.coefficient} | states

    def card(self) -> Card:
        """The card of ``trpo`` with the hyperparameters and the stored states of the method."""
        card = super().card()
        settings = {**card.hyperparameters, **self._method_settings()}
        return replace(card, hyperparameters=settings, stored_steps=card.stored_steps + self._most_stored)

    def _state(self) -> dict[str, Array]:
        stored = {f"stored_{name}": values for name, values in self._stored.items()}
        return super()._state() | stored | {"most_stored": np.array(self._most_stored)}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        names = [name for name in arrays if name.startswith("stored_")]
        self._stored = {name.removeprefix("stored_"): arrays[name] for name in names}
        self._most_stored = int(arrays["most_stored"])


class QuadraticTrpo(RegularizedTrpo):
    """An agent with a :class:`Quadratic` penalty; a subclass chooses the anchor and the importance."""

    def _penalty(self) -> Quadratic | None:
        """None while nothing is anchored or if the coefficient is 0."""
        if not (self.coefficient and self._stored):
            return None
        return Quadratic(self.coefficient, self._stored["importance"], self._stored["anchor"])

    def _anchor(self, importance: Array) -> None:
        """Anchors the present parameters, with these importances (p,)."""
        self._stored = {"anchor": self._theta.copy(), "importance": importance.astype(self._theta.dtype)}


class L2(QuadraticTrpo):
    """The agent ``l2``: c/2 · Σᵢ (θᵢ − θ*ᵢ)², with θ* the parameters after the previous task."""

    name, title = "l2", "TRPO + L2"
    description = "The reference agent with an L2 penalty to the policy's weights after the previous task."
    published_coefficient = 0.1  # docs/learners.md

    def _end_of_task(self, observations: Array) -> None:
        self._anchor(np.ones_like(self._theta))


class L2Init(QuadraticTrpo):
    """The agent ``l2-init``: c/2 · Σᵢ (θᵢ − θ⁰ᵢ)², with θ⁰ the initial parameters, from the first task on.

    It does not use the boundaries of tasks.
    """

    name, title = "l2-init", "TRPO + L2 Init"
    description = "The reference agent with an L2 penalty to the policy's initial weights."
    parent = ""
    observes = Observes()
    published_coefficient = 0.01  # docs/learners.md

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self._anchor(np.ones_like(self._theta))


def diagonal_fisher(architecture: policies.Architecture, theta: Array, inputs: Array) -> Array:
    """Mean over the states of Σₐ (∂μₐ/∂θᵢ)² / σₐ², and 2 for log σ; float64 (p,).

    The expectation over actions is exact, as in Wolczyk et al. 2021, appendix. ``inputs`` (n, o) are those of
    the network, n > 0.
    """
    outputs, activation = architecture.sizes[-1], policies.ACTIVATIONS[architecture.activation]
    values, views = policies.forward(architecture, theta, inputs), policies.layers(architecture.sizes, theta)
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
                upstream = upstream @ views[layer][0].T
                policies.times_slope(upstream, values[layer], activation)
        total += np.concatenate(parts[::-1])
    total /= len(inputs)
    total[-outputs:] = 2.0
    return total


def accumulated(fisher: Array, importance: Array | None, decay: float) -> Array:
    """The importance of online EWC after a task, γ (ω + F / mean F), from that before it, None at first."""
    normalized = fisher / fisher.mean()
    if importance is not None:
        normalized += importance
    return decay * normalized


class OnlineEwc(QuadraticTrpo):
    """The agent ``online-ewc`` (Kirkpatrick et al. 2017; Schwarz et al. 2018).

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
        self._anchor(accumulated(fisher, self._stored.get("importance"), self.decay))

    def _method_settings(self) -> Mapping[str, Setting]:
        return {"coefficient": self.coefficient, "decay": self.decay, "states_per_task": self.states_per_task}


@dataclass(frozen=True)
class Divergence:
    """c · mean KL(old ‖ new) over stored states, in nats, summed over the action's components."""

    coefficient: float  # c
    architecture: policies.Architecture  # of the policy
    inputs: Array  # of the network at the stored states (n, o)
    means: Array  # of the old policies at these states (n, a)
    log_sigmas: Array  # of the old policies (n, a)

    def value(self, theta: Array) -> float:
        mean, log_sigma = policies.mean_and_log_sigma(self.architecture, theta, self.inputs)
        spread = (np.exp(2 * self.log_sigmas) + (mean - self.means) ** 2) * np.exp(-2 * log_sigma)
        terms = log_sigma - self.log_sigmas + 0.5 * spread - 0.5
        return self.coefficient * float(np.sum(terms, dtype=np.float64)) / len(terms)

    def gradient(self, theta: Array) -> Array:
        """Its gradient (p,): (μ − μ_old) / σ² over the means, 1 − (σ_old² + (μ − μ_old)²) / σ² over log σ."""
        values = policies.forward(self.architecture, theta, self.inputs)
        log_sigmas = self.architecture.log_sigmas
        precision = np.exp(-2 * theta[log_sigmas])
        gap = policies.means(self.architecture, values[-1]) - self.means
        whole = policies.gradient(self.architecture, theta, values, gap * precision / len(gap))
        whole[log_sigmas] = np.mean(1 - (np.exp(2 * self.log_sigmas) + gap * gap) * precision, axis=0)
        return theta.dtype.type(self.coefficient) * whole

    def curvature(self, theta: Array) -> update.Curvature:
        """c times the Fisher matrix over the stored states, the second derivative where new = old."""
        values = policies.forward(self.architecture, theta, self.inputs)
        product = policies.fisher_product(self.architecture, theta, values, damping=0.0)
        coefficient = theta.dtype.type(self.coefficient)
        return update.Curvature(lambda vector: coefficient * product(vector))


def appended(stored: Mapping[str, Array], new: Mapping[str, Array]) -> dict[str, Array]:
    """What is stored of all tasks: the rows of those before, if any, and the new ones."""
    if not stored:
        return {name: np.array(rows) for name, rows in new.items()}
    return {name: np.concatenate([stored[name], rows]) for name, rows in new.items()}


class Cloning(RegularizedTrpo):
    """The agent ``cloning``: the policy is held to what earlier policies did in the states of their tasks.

    From Rusu et al. 2016 and Wolczyk et al. 2022. The observations are stored raw, with the old means and
    log σ. So a state keeps its target when the moments of the observations change.
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
        means, log_sigmas = self._stored["means"], self._stored["log_sigmas"]
        return Divergence(self.coefficient, self._architecture, inputs, means, log_sigmas)

    def _end_of_task(self, observations: Array) -> None:
        inputs = self._policy_inputs(observations)
        means, log_sigma = policies.mean_and_log_sigma(self._architecture, self._theta, inputs)
        log_sigmas = np.broadcast_to(log_sigma, means.shape)
        new = {"observations": observations, "means": means, "log_sigmas": log_sigmas}
        self._stored = appended(self._stored, new)
