"""The value function: an MLP that standardizes its inputs and its targets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.mlp import (
    ACTIVATIONS,
    Layers,
    Sizes,
    forward,
    gradient,
    initial,
    layers,
    slopes,
)
from gym_extensions.baselines.trpo.normalization import Moments, merge, no_moments, standardize

FIRST_DECAY, SECOND_DECAY, EPSILON = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma and Ba 2015)."""


@dataclass(frozen=True)
class ValueFit:
    """The value network and its regression on discounted returns.

    Args:
        hidden: widths of the hidden layers.
        activation: name of the hidden activation.
        learning_rate: Adam's step size.
        minibatches: minibatches per epoch, as far as the two limits on their size allow.
        smallest_minibatch: fewest samples per minibatch.
        largest_minibatch: most samples per minibatch.
        epochs: passes over a batch.
        samples: batches on which ``epochs`` passes exceed this number of samples get fewer, at least two.
    """

    hidden: tuple[int, ...] = (64, 64)
    activation: str = "relu"
    learning_rate: float = 1e-3
    minibatches: int = 16
    smallest_minibatch: int = 128
    largest_minibatch: int = 512
    epochs: int = 10
    samples: int = 100_000


class ValueFunction:
    """Predicts discounted returns; its whole state is the arrays in ``state``."""

    def __init__(self, observations: int, rng: np.random.Generator, fit: ValueFit) -> None:
        self._fit, self._activation = fit, ACTIVATIONS[fit.activation]
        self._sizes: Sizes = (observations, *fit.hidden, 1)
        theta = initial(self._sizes, rng)
        self.state: dict[str, Array] = {
            "theta": theta,
            "first": np.zeros_like(theta),
            "second": np.zeros_like(theta),
            "updates": np.zeros(1),
            "level": np.array([0.0, 1.0]),
        }
        self._store(no_moments(observations))

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return int(self.state["theta"].size)

    def predict(self, observations: Array) -> Array:
        """Values (n,) float64 of observations (n, o).

        Before the first ``fit`` no moments are known, so that all inputs are at the bounds of the clip and
        the advantages of the first batch are noisy. Zeros would be better, but give other runs.
        """
        inputs = standardize(self._moments(), observations, least=0.0)
        mean, deviation = self.state["level"]
        output = forward(layers(self._sizes, self.state["theta"]), inputs, self._activation)[-1][:, 0]
        values: Array = output.astype(np.float64) * deviation + mean
        return values

    def fit(self, observations: Array, targets: Array, rng: np.random.Generator) -> None:
        """Moves the predictions towards the targets (n,) by a few epochs of Adam on the squared error."""
        self._store(merge(self._moments(), observations))
        self._rescale(targets)
        mean, deviation = self.state["level"]
        inputs = standardize(self._moments(), observations, least=0.0)
        scaled = ((targets - mean) / deviation).astype(np.float32)
        fit, count = self._fit, len(inputs)
        size = min(fit.largest_minibatch, max(fit.smallest_minibatch, -(-count // fit.minibatches)))
        views = layers(self._sizes, self.state["theta"])
        for _ in range(max(2, min(fit.epochs, fit.samples // count))):
            order = rng.permutation(count)
            shuffled, goals = inputs[order], scaled[order, None]
            for start in range(0, count, size):
                self._descend(views, shuffled[start : start + size], goals[start : start + size])

    def _descend(self, views: Layers, inputs: Array, targets: Array) -> None:
        """One step of Adam on the parameters, whose views are ``views``; all arrays are changed in place."""
        state = self.state
        values = forward(views, inputs, self._activation)
        upstream = (values[-1] - targets) * np.float32(2 / len(inputs))
        slope = gradient(views, values, slopes(values, self._activation), upstream)
        state["updates"] += 1
        count = float(state["updates"][0])
        state["first"] += np.float32(1 - FIRST_DECAY) * (slope - state["first"])
        state["second"] += np.float32(1 - SECOND_DECAY) * (slope * slope - state["second"])
        rate = self._fit.learning_rate * np.sqrt(1 - SECOND_DECAY**count) / (1 - FIRST_DECAY**count)
        state["theta"] -= np.float32(rate) * state["first"] / (np.sqrt(state["second"]) + np.float32(EPSILON))

    def _moments(self) -> Moments:
        return Moments(float(self.state["count"][0]), self.state["mean"], self.state["squares"])

    def _store(self, moments: Moments) -> None:
        count = np.array([moments.count])
        self.state |= {"count": count, "mean": moments.mean, "squares": moments.squares}

    def _rescale(self, targets: Array) -> None:
        """Adopts the targets' mean and deviation; the last layer is changed to keep every prediction.

        This is Pop-Art (van Hasselt et al. 2016) with the statistics of the present batch.
        """
        mean, deviation = self.state["level"]
        new_mean, new_deviation = float(targets.mean()), max(float(targets.std()), 1e-6)
        weights, bias = layers(self._sizes, self.state["theta"])[-1]
        weights *= np.float32(deviation / new_deviation)
        bias[:] = (bias * deviation + mean - new_mean) / new_deviation
        self.state["level"] = np.array([new_mean, new_deviation])
