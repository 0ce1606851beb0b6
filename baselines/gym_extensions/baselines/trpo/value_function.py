"""The value function: an MLP in place of rllab's linear baseline; it standardises what goes in and out."""

from __future__ import annotations

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.trpo.mlp import Sizes, forward, gradient, initial, layers, slopes

HIDDEN = (64, 64)
LEARNING_RATE, FIRST_DECAY, SECOND_DECAY, EPSILON = 1e-3, 0.9, 0.999, 1e-8
MINIBATCHES, SMALLEST_MINIBATCH, LARGEST_MINIBATCH = 16, 128, 512
MOST_EPOCHS, SAMPLES = 10, 100_000
"""Passes over a batch: ten; fewer, at least two, where they would see more samples than that."""
WIDEST = 10.0
"""Standardised observations are cut here, in standard deviations."""


class ValueFunction:
    """Predicts discounted returns; its state is the arrays in ``state``."""

    def __init__(self, observations: int, rng: np.random.Generator) -> None:
        self._sizes: Sizes = (observations, *HIDDEN, 1)
        theta = initial(self._sizes, rng)
        self.state: dict[str, Array] = {
            "theta": theta,
            "first": np.zeros_like(theta),
            "second": np.zeros_like(theta),
            "updates": np.zeros(1),
            "seen": np.zeros(1),
            "centre": np.zeros(observations),
            "spread": np.zeros(observations),
            "level": np.array([0.0, 1.0]),
        }

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return int(self.state["theta"].size)

    def predict(self, observations: Array) -> Array:
        """Values (n,) float64 of observations (n, o)."""
        inputs = self._standardised(observations)
        mean, deviation = self.state["level"]
        output = forward(layers(self._sizes, self.state["theta"]), inputs)[-1][:, 0]
        values: Array = output.astype(np.float64) * deviation + mean
        return values

    def fit(self, observations: Array, targets: Array, rng: np.random.Generator) -> None:
        """Moves the prediction towards the targets (n,) by a few epochs of Adam on squared error."""
        self._see(observations)
        self._relevel(targets)
        mean, deviation = self.state["level"]
        inputs, wanted = self._standardised(observations), ((targets - mean) / deviation).astype(np.float32)
        size = min(LARGEST_MINIBATCH, max(SMALLEST_MINIBATCH, -(-len(inputs) // MINIBATCHES)))
        for _ in range(max(2, min(MOST_EPOCHS, SAMPLES // len(inputs)))):
            order = rng.permutation(len(inputs))
            for at in range(0, len(order), size):
                part = order[at : at + size]
                self._descend(inputs[part], wanted[part])

    def _descend(self, inputs: Array, wanted: Array) -> None:
        state = self.state
        views = layers(self._sizes, state["theta"])
        values = forward(views, inputs)
        upstream = (values[-1] - wanted[:, None]) * np.float32(2 / len(inputs))
        slope = gradient(views, values, slopes(values), upstream)
        state["updates"] += 1
        count = float(state["updates"][0])
        state["first"] += np.float32(1 - FIRST_DECAY) * (slope - state["first"])
        state["second"] += np.float32(1 - SECOND_DECAY) * (slope * slope - state["second"])
        rate = LEARNING_RATE * np.sqrt(1 - SECOND_DECAY**count) / (1 - FIRST_DECAY**count)
        state["theta"] -= np.float32(rate) * state["first"] / (np.sqrt(state["second"]) + np.float32(EPSILON))

    def _standardised(self, observations: Array) -> Array:
        state = self.state
        deviation = np.sqrt(state["spread"] / max(float(state["seen"][0]), 1.0)) + 1e-8
        return np.clip((observations - state["centre"]) / deviation, -WIDEST, WIDEST).astype(np.float32)

    def _see(self, observations: Array) -> None:
        """Adds a batch to the running mean and sum of squared deviations (Chan et al. 1979)."""
        state, new = self.state, observations.astype(np.float64)
        count, seen = len(new), float(state["seen"][0])
        gap = new.mean(axis=0) - state["centre"]
        state["spread"] += np.square(new - new.mean(axis=0)).sum(axis=0) + gap**2 * seen * count / (
            seen + count
        )
        state["centre"] += gap * count / (seen + count)
        state["seen"] += count

    def _relevel(self, targets: Array) -> None:
        """Takes the targets' mean and deviation as scale; the last layer is changed to predict as before."""
        mean, deviation = self.state["level"]
        new_mean, new_deviation = float(targets.mean()), max(float(targets.std()), 1e-6)
        weights, bias = layers(self._sizes, self.state["theta"])[-1]
        weights *= np.float32(deviation / new_deviation)
        bias[:] = (bias * deviation + mean - new_mean) / new_deviation
        self.state["level"] = np.array([new_mean, new_deviation])
