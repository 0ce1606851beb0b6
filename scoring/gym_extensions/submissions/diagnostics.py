"""Diagnostics: what training does to networks, their ranks, units without effect, and divergence; on the
published observations of the tasks of a submission.

``gym-extensions maintain diagnostics`` computes them and writes ``diagnostics/<group>.json`` into the
submission's folder. Loads no simulator.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Annotated, Literal, NamedTuple

import numpy as np

from gym_extensions.catalog import states
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import IN_ORDER, task_order
from gym_extensions.documents import JsonDocument, about
from gym_extensions.files import write_text
from gym_extensions.metrics.statistics import interval
from gym_extensions.metrics.values import MetricValue
from gym_extensions.submissions.layout import DIAGNOSTICS, DOCUMENT
from gym_extensions.submissions.policies import mlp
from gym_extensions.submissions.policies.files import AnyPolicy, Key
from gym_extensions.submissions.policies.mlp_arrays import Array, require_size
from gym_extensions.submissions.run import read_run

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
            Vershynin 2007, "Sampling from large matrices").
        inactive: of each hidden layer the share of its outputs that are saturated (tanh: at least .9), or of
            its units that are dormant (other activations): their mean absolute output is at most .025 of the
            mean over the layer (Sokar et al. 2023, "The dormant neuron phenomenon").
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
        masks = policy.masks or (None,) * len(policy.weights)
        layers = (
            each if mask is None else each * mask for each, mask in zip(policy.weights, masks, strict=True)
        )
        sigmas = (each for each in (policy.log_sigma, policy.log_sigma_weight) if each is not None)
        seen = [mlp.hidden_outputs(policy, part, task) for task, part in enumerate(observations)]
        hidden = [np.concatenate(parts) for parts in zip(*seen, strict=True)]
        previous = ((policies[stage - 1], task) for task in range(len(observations)))
        learned = list(order or range(len(observations)))[: max(stage - 1, 0)]
        diagnosis = Diagnosis(
            parameters=sum(each.size for each in (*policy.weights, *policy.biases, *sigmas)),
            norms=tuple(float(np.linalg.norm(layer)) for layer in layers),
            ranks=tuple(map(stable_rank, hidden)),
            inactive=tuple(inactive_share(outputs, policy.activation) for outputs in hidden),
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


COMMAND = "gym-extensions maintain diagnostics"
MEASURES = ("ranks", "inactive")


@dataclass(frozen=True, slots=True)
class DiagnosedRun:
    """The policies of a run."""

    policies: Annotated[str, about("digest of the run's policies")]
    diagnoses: Annotated[tuple[Diagnosis, ...], about("of each policy, by stage, in `single` by task")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostics(JsonDocument):
    """The diagnostics of a submission on a group."""

    format: Annotated[Literal[1], about("1")] = 1
    group: Annotated[str, about("group id")]
    states: Annotated[int, about("version of the observations")]
    runs: Annotated[dict[str, DiagnosedRun], about("by name, such as `hopper-gravity/sequential/run0`")]


def path_of(submission: Path, group: TaskGroup) -> Path:
    """The file of a group's diagnostics in a submission's folder."""
    return submission / DIAGNOSTICS / f"{group.name}.json"


def write(submission: Path, group: TaskGroup, runs: Mapping[str, DiagnosedRun]) -> Path:
    """Writes the diagnostics of a group, whole or not at all, and returns their path."""
    path = path_of(submission, group)
    document = Diagnostics(group=group.id, states=states.VERSION, runs=dict(runs))
    write_text(path, document.to_json())
    return path


def load(submission: Path, group: TaskGroup) -> dict[str, DiagnosedRun]:
    """The diagnosed runs by name whose policies and observations are the present ones.

    Raises ``BenchError`` if a file cannot be read.
    """
    found = Diagnostics.load(path_of(submission, group), "bad-diagnostics", COMMAND)
    if found is None or found.states != states.VERSION:
        return {}
    paths = {name: submission / f"{name}{DOCUMENT}" for name in found.runs}
    stated = {name: read_run(path).policies for name, path in paths.items() if path.is_file()}
    return {
        name: run
        for name, run in found.runs.items()
        if (at := stated.get(name)) and at.sha256 == run.policies
    }


class Change(NamedTuple):
    """A number of the last hidden layer: means over runs at three stages, the change from first to last."""

    untrained: float
    first: float
    last: float
    change: MetricValue


def changes(submission: Path) -> dict[str, dict[str, Change]]:
    """By group id, how ``ranks`` and ``inactive`` change in the sequential runs of a submission.

    Raises ``BenchError`` if a file cannot be read.
    """
    found: dict[str, dict[str, Change]] = {}
    for group in GROUPS.values():
        runs = [run.diagnoses for name, run in load(submission, group).items() if "/sequential/" in name]
        for measure in MEASURES:
            layers = [[getattr(each, measure) for each in diagnoses] for diagnoses in runs]
            if runs and all(each for stages in layers for each in stages):
                stages = [[each[-1] for each in stages] for stages in layers]
                values = [each[-1] - each[1] for each in stages]
                untrained, first, last = (fmean(each[at] for each in stages) for at in (0, 1, -1))
                change = MetricValue.of(interval(values), values)
                found.setdefault(group.id, {})[measure] = Change(untrained, first, last, change)
    return found
