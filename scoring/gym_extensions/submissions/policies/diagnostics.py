"""What training does to a network: its size, the ranks of its layers, units without effect, divergence."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np

from gym_extensions.catalog.protocol import IN_ORDER, task_order
from gym_extensions.submissions.policies import mlp
from gym_extensions.submissions.policies.files import AnyPolicy, Key
from gym_extensions.submissions.policies.mlp_arrays import Array, require_size

SATURATED = 0.9
"""Absolute output from which a tanh unit counts as saturated: its slope is below .2, that at 0 is 1."""
DORMANT = 0.025
"""Share of the layer's mean absolute output up to which a unit counts as dormant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnosis:
    """A policy on prescribed observations, and its differences from those of earlier stages.

    None: it cannot be said, as of a network (ONNX), whose layers have no order, and of the first stage, which
    follows none.

    Args:
        parameters: the number of weights, biases and log σ; of a network of its weights.
        norms: the Frobenius norm of each layer's weights, without masked ones.
        ranks: the stable rank of each hidden layer's outputs H (observations, units), less their mean:
            ‖H‖² (Frobenius) / ‖H‖² (spectral). It is at least 1 and at most the number of units (Rudelson &
            Vershynin 2007, "Sampling from large matrices"). It is that of the network that acts in a task, on
            the task's observations, as the mean over tasks.
        inactive: of each hidden layer the share of its outputs that are saturated (tanh: at least .9), or of
            its units that are dormant (other activations): their mean absolute output is at most .025 of the
            mean over the layer (Sokar et al. 2023, "The dormant neuron phenomenon"). Also a mean over tasks.
        distances: the Euclidean distance of all weights from those after each earlier stage, from 0.
        kl: for each task, the mean over its observations of the divergence KL(stage before ‖ now) of the
            Gaussian policies, in nats.
        drift: for each task that was trained before the last one, in training order, the divergence KL(right
            after its training ‖ now) on its observations.
    """

    parameters: int | None = None
    norms: tuple[float, ...] | None = None
    ranks: tuple[float, ...] | None = None
    inactive: tuple[float, ...] | None = None
    distances: tuple[float, ...] | None = None
    kl: tuple[float, ...] | None = None
    drift: tuple[float, ...] | None = None


def diagnose(
    policies: Sequence[AnyPolicy], observations: Sequence[Array], order: Sequence[int] | None = None
) -> tuple[Diagnosis, ...]:
    """The diagnoses of the policies of a run, stage by stage.

    Args:
        policies: after every stage, from the untrained one.
        observations: (n, …) of every task of the group, in its order.
        order: the indices of the tasks in the order of training; that of the group if None.

    Raises:
        BenchError: the observations have another size than those of a policy.
    """
    found, weights = [], [each.flat_weights() for each in policies]
    for stage, policy in enumerate(policies):
        before = [weights[stage] - each for each in weights[:stage] if each.size == weights[stage].size]
        distances = tuple(float(np.linalg.norm(each)) for each in before) if len(before) == stage else None
        if not isinstance(policy, mlp.Policy):
            for part in observations:
                require_size(part, policy.num_inputs)
            found.append(Diagnosis(parameters=weights[stage].size, distances=distances))
            continue
        sigmas = (each for each in (policy.log_sigma, policy.log_sigma_weight) if each is not None)
        seen = [mlp.hidden_outputs(policy, part, task) for task, part in enumerate(observations)]
        hidden = list(zip(*seen, strict=True))  # by layer and task
        previous = ((policies[stage - 1], task) for task in range(len(observations)))
        learned = list(order or range(len(observations)))[: max(stage - 1, 0)]
        diagnosis = Diagnosis(
            parameters=sum(each.size for each in (*policy.weights, *policy.biases, *sigmas)),
            norms=tuple(float(np.linalg.norm(layer)) for layer in policy.masked_weights),
            ranks=tuple(fmean(map(stable_rank, layer)) for layer in hidden),
            inactive=tuple(
                fmean(inactive_share(outputs, policy.activation) for outputs in layer) for layer in hidden
            ),
            distances=distances,
            kl=divergences(policy, previous, observations) if stage else None,
            drift=divergences(policy, zip(policies[1:], learned, strict=False), observations),
        )
        found.append(diagnosis)
    return tuple(found)


def diagnose_run(
    policies: Mapping[Key, AnyPolicy], observations: Sequence[Array], protocol: str, run: int
) -> tuple[Diagnosis, ...]:
    """The diagnoses of all policies of a run; in the protocols with one stage, each is by itself."""
    if protocol in IN_ORDER:
        order = task_order(protocol, run, len(observations))
        return diagnose(list(policies.values()), observations, order)
    return tuple(each for policy in policies.values() for each in diagnose([policy], observations))


def stable_rank(outputs: Array) -> float:
    """The stable rank of outputs (n, units) less their mean; 1 if they do not vary."""
    squares = np.linalg.svd(outputs - outputs.mean(axis=0), compute_uv=False) ** 2
    return float(squares.sum() / squares[0]) if squares[0] > 0 else 1.0


def inactive_share(outputs: Array, activation: str) -> float:
    """The share of outputs (n, units) that are saturated, or of units that are dormant."""
    if activation == "tanh":
        return float((np.abs(outputs) >= SATURATED).mean())
    means = np.abs(outputs).mean(axis=0)
    return float((means <= DORMANT * means.mean()).mean())


def divergences(
    now: mlp.Policy, pairs: Iterable[tuple[AnyPolicy, int]], observations: Sequence[Array]
) -> tuple[float, ...] | None:
    """The mean KL(before ‖ now) for each earlier policy on the observations of a task, given by its index.

    None if a policy states no σ, has another scale of actions, or is a network (ONNX).
    """
    found = []
    for before, task in pairs:
        if not isinstance(before, mlp.Policy) or before.log_sigma is None or now.log_sigma is None:
            return None
        scales = ((each.squash, *each.action_offset, *each.action_scale) for each in (before, now))
        if len(set(scales)) > 1:
            return None
        both = (mlp.mean_and_log_sigma(each, observations[task], task) for each in (before, now))
        (old_mean, old), (mean, log_sigma) = both
        variances = np.exp(2 * old) + (old_mean - mean) ** 2
        terms = log_sigma - old + variances / (2 * np.exp(2 * log_sigma)) - 0.5
        found.append(float(terms.sum(axis=-1).mean()))
    return tuple(found)
