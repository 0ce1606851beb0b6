"""Batches of transitions, their advantages, and the value function."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.baselines.trust_region import policy
from gym_extensions.files import compiled


@dataclass(frozen=True)
class Transitions:
    """T vector steps: observations (T + 1, num_envs, o); the rest (T, num_envs, …).

    ``valid`` is False in the rows in which an environment was being reset.
    """

    observations: Array
    actions: Array
    rewards: Array
    terminated: Array
    truncated: Array
    valid: Array


class Collector:
    """A vector environment between two batches: episodes continue across batches."""

    def __init__(self, env: VectorEnv) -> None:
        observations, _ = env.reset()
        self._env = env
        self._observations: Array = np.array(observations, np.float32)
        self._resetting = np.zeros(env.num_envs, bool)

    def collect(
        self, sample: Callable[[Array], Array], to_env: Callable[[Array], Array], transitions: int
    ) -> Transitions:
        """Steps until at least ``transitions`` are taken; fewer than ``num_envs`` are taken beyond that.

        The steps that reset an environment do not count. ``sample`` gives the policy's actions (num_envs, a)
        for observations (num_envs, o), and ``to_env`` maps them to the environment's action box.
        """
        observations, rows, count = [self._observations], [], 0
        while count < transitions:
            action = sample(observations[-1])
            next_observations, reward, ends, cuts, _ = self._env.step(to_env(action))
            stepped = ~self._resetting
            self._resetting = (ends | cuts) & stepped
            count += int(stepped.sum())
            observations.append(np.array(next_observations, np.float32))
            rows.append((action, np.array(reward, np.float64), np.array(ends), np.array(cuts), stepped))
        self._observations = observations[-1]
        actions, rewards, terminated, truncated, valid = map(np.stack, zip(*rows, strict=True))
        return Transitions(np.stack(observations), actions, rewards, terminated, truncated, valid)


def advantages(
    rewards: Array, values: Array, terminated: Array, truncated: Array, *, discount: float, gae_lambda: float
) -> Array:
    """Advantages (T, num_envs) for rewards (T, num_envs) and values (T + 1, num_envs).

    Row t + 1 of ``values`` belongs to the state after step t. A terminated step has no value after it. A
    truncated step (time limit) is bootstrapped with the value of the state it leads to, as is the last row.
    The rows of a reset, which follow an episode's end, are meaningless; the caller drops them.
    """
    estimates = np.empty(rewards.shape, np.float64)
    running = np.zeros(rewards.shape[1])
    ended = terminated | truncated
    for t in range(len(rewards) - 1, -1, -1):
        residual = rewards[t] + discount * values[t + 1] * ~terminated[t] - values[t]
        running = residual + discount * gae_lambda * ~ended[t] * running
        estimates[t] = running
    return estimates


FIRST_DECAY, SECOND_DECAY, EPSILON = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma and Ba 2015)."""


@compiled
def adam_steps(  # noqa: PLR0917
    sizes: policy.Sizes,
    theta: Array,
    first: Array,
    second: Array,
    inputs: Array,
    targets: Array,
    size: int,
    rates: Array,
) -> None:
    """Steps of Adam, one per rate, on the squared error of a network with ReLUs on minibatches of a size.

    ``theta`` (p,) and the moments of its gradient, ``first`` and ``second`` (p,), change in place. ``inputs``
    are (n, o), ``targets`` (n, 1); all are float32.
    """
    first_share, second_share = np.float32(1 - FIRST_DECAY), np.float32(1 - SECOND_DECAY)
    last, slope = len(sizes) - 2, np.zeros_like(theta)
    for step in range(len(rates)):
        rows = slice(step * size, (step + 1) * size)
        values = [inputs[rows]]
        for number in range(last + 1):
            weights, bias = policy.layer(sizes, theta, number)
            outputs = np.dot(values[number], weights)
            for row in range(len(outputs)):
                for unit in range(bias.size):
                    output = outputs[row, unit] + bias[unit]
                    outputs[row, unit] = output if output > 0 or number == last else np.float32(0)
            values.append(outputs)
        upstream = (values[-1] - targets[rows]) * np.float32(2 / len(values[0]))
        slope[:] = 0
        policy.add_gradient(sizes, theta, policy.RELU, values, upstream, slope)
        for j in range(theta.size):
            first[j] += first_share * (slope[j] - first[j])
            second[j] += second_share * (slope[j] * slope[j] - second[j])
            theta[j] -= rates[step] * first[j] / (np.sqrt(second[j]) + np.float32(EPSILON))


@dataclass(frozen=True)
class ValueFit:
    """The value network, with ReLUs, and its regression on discounted returns."""

    hidden: tuple[int, ...] = (64, 64)
    learning_rate: float = 1e-3  # Adam's step size
    minibatches: int = 16  # per epoch, as far as the two limits on their size allow
    smallest_minibatch: int = 128
    largest_minibatch: int = 512
    epochs: int = 10  # passes over a batch
    samples: int = 100_000  # batches on which the passes exceed it get fewer passes, at least two


class ValueFunction:
    """Predicts discounted returns; its whole state is the arrays in ``state``."""

    def __init__(self, observations: int, rng: np.random.Generator, fit: ValueFit) -> None:
        self._fit = fit
        self._architecture = policy.Architecture((observations, *fit.hidden, 1), "relu")
        theta = policy.initial(self._architecture.sizes, rng)
        self.state: dict[str, Array] = {
            "theta": theta,
            "first": np.zeros_like(theta),
            "second": np.zeros_like(theta),
            "updates": np.zeros(1),
            "level": np.array([0.0, 1.0]),
            "count": np.zeros(1),
            "mean": np.zeros(observations),
            "squares": np.zeros(observations),
        }

    @property
    def parameters(self) -> int:
        return int(self.state["theta"].size)

    def predict(self, observations: Array) -> Array:
        """Values (n,) float64 of observations (n, o).

        Before the first ``fit`` no moments are known, so that all inputs are at the bounds of the clip and
        the advantages of the first batch are noisy. Zeros would be better; they would change every published
        run.
        """
        inputs = policy.standardize(self._moments(), observations, least=0.0)
        mean, deviation = self.state["level"]
        outputs = policy.outputs(self._architecture, self.state["theta"], inputs)[:, 0]
        return outputs.astype(np.float64) * deviation + mean

    def fit(self, observations: Array, targets: Array, rng: np.random.Generator) -> None:
        """Moves the predictions towards the targets (n,) by a few epochs of Adam on the squared error."""
        moments = policy.merge(self._moments(), observations)
        self.state |= {"count": np.array([moments.count]), "mean": moments.mean, "squares": moments.squares}
        self._rescale(targets)
        mean, deviation = self.state["level"]
        inputs = policy.standardize(moments, observations, least=0.0)
        scaled = ((targets - mean) / deviation).astype(np.float32)
        fit, count = self._fit, len(inputs)
        size = min(fit.largest_minibatch, max(fit.smallest_minibatch, -(-count // fit.minibatches)))
        theta, first, second = (self.state[name] for name in ("theta", "first", "second"))
        for _ in range(max(2, min(fit.epochs, fit.samples // count))):
            order = rng.permutation(count)
            updates = self.state["updates"] + np.arange(1, -(-count // size) + 1)
            rates = fit.learning_rate * np.sqrt(1 - SECOND_DECAY**updates) / (1 - FIRST_DECAY**updates)
            batch = inputs[order], scaled[order, None], size, rates.astype(np.float32)
            adam_steps(self._architecture.sizes, theta, first, second, *batch)
            self.state["updates"] = updates[-1:]

    def _moments(self) -> policy.Moments:
        return policy.Moments(float(self.state["count"][0]), self.state["mean"], self.state["squares"])

    def _rescale(self, targets: Array) -> None:
        """Adopts the targets' mean and deviation; the last layer is changed to keep every prediction.

        This is Pop-Art (van Hasselt et al. 2016) with the statistics of the present batch.
        """
        mean, deviation = self.state["level"]
        new_mean, new_deviation = float(targets.mean()), max(float(targets.std()), 1e-6)
        weights, bias = policy.layers(self._architecture.sizes, self.state["theta"])[-1]
        weights *= np.float32(deviation / new_deviation)
        bias[:] = (bias * deviation + mean - new_mean) / new_deviation
        self.state["level"] = np.array([new_mean, new_deviation])
