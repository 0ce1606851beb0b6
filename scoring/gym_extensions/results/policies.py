"""Stored policies as a data frame: what each returns on every task, and what training did to its network."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pandas as pd

from gym_extensions.catalog.groups import Groups, TaskGroup
from gym_extensions.catalog.protocol import IN_ORDER, task_order
from gym_extensions.catalog.states import states
from gym_extensions.errors import BenchError
from gym_extensions.metrics.statistics import Summary, mean_of_groups, summary, to_interval
from gym_extensions.references import load_references
from gym_extensions.results.frames import dtypes_of, read_groups
from gym_extensions.scoring.output.board_frames import typed
from gym_extensions.scoring.pipeline import Paths
from gym_extensions.submissions import diagnostics, layout
from gym_extensions.submissions.policies import files, mlp_arrays
from gym_extensions.submissions.policies.diagnostics import Diagnosis, diagnose_run
from gym_extensions.submissions.run import RunDocument
from gym_extensions.submissions.submission import runs_folder


def policies(submissions: Paths = "submissions", *, groups: Groups = ()) -> pd.DataFrame:
    """Every stored policy, one per row: its returns on every task, and what training did to its network.

    ==========  =======  ==========================================================================
    column      dtype    value
    ==========  =======  ==========================================================================
    submission  str      name of the submission's folder
    method      str      the algorithm, as the submission names it
    group       str      group id
    protocol    str      ``sequential``, ``single`` or another one (docs/concepts.md)
    run         int64    training seed
    stage       int64    number of tasks trained so far: 0 untrained; 1 in the other protocols
    task        str      id of the task that was trained last; empty before training and in ``joint``
    returns     object   mean return on each task of the group in its order; NaN where not evaluated
    scores      object   the same: 0 = floor, 1 = expert; NaN for a task without an expert
    parameters  Int64    number of weights, biases and log σ
    norms       object   Frobenius norm of the weights of each layer
    ranks       object   stable rank of the outputs of each hidden layer
    inactive    object   share of saturated (tanh) or dormant outputs of each hidden layer
    distances   object   Euclidean distances of the weights from those after each earlier stage
    kl          object   KL(stage before ‖ this stage) on the observations of each task, in nats
    drift       object   for each task before the last trained one: KL(right after its training ‖ now)
    why         str      why the columns from ``parameters`` are missing; else empty
    ==========  =======  ==========================================================================

    Objects are tuples, or None without a value (docs/metrics.md, "Networks"). They come from the folder
    ``diagnostics`` of the submission; for runs that it lacks they are computed, which takes some milliseconds
    per policy. Policies that lie elsewhere are not fetched.

    The arguments and errors are those of :func:`episodes`.
    """
    rows: list[tuple[object, ...]] = []
    references = load_references().tasks
    for submission, submitted in read_groups(submissions, groups):
        method = submission.manifest.protocol.algorithm if submission.manifest else ""
        experts = [references.get(task) for task in submitted.group.task_ids]
        for protocol, log in submitted.logs.items():
            documents = [submitted.runs[protocol][run] for run in log.runs]
            published = [document for document in documents if document.policies]
            diagnosed = _diagnosed(submission.path, submitted.group, published)
            cells = log.rows.groupby(["run", "stage", "position"])["return"].mean().unstack()
            returns = dict(zip(cells.index, cells.to_numpy(), strict=True))
            for document, (diagnoses, why) in zip(published, diagnosed, strict=True):
                keys = submission.name, method, submitted.group.id, protocol, document.run
                for stage, at, diagnosis in zip(*_stages(document, submitted.group), diagnoses, strict=True):
                    means = returns[document.run, stage]
                    if protocol == "single":  # a policy is evaluated on its own task
                        means = np.where(np.arange(len(means)) == at, means, np.nan)
                    task = "" if at is None else submitted.group.task_ids[at]
                    scores = tuple(
                        math.nan if expert is None or expert.open else expert.normalize(mean)
                        for expert, mean in zip(experts, means, strict=True)
                    )
                    rows.append((*keys, stage, task, tuple(means), scores, *astuple(diagnosis), why))
    return typed(rows, dtypes_of(policies))


def _stages(document: RunDocument, group: TaskGroup) -> tuple[list[int], list[int | None]]:
    """The stage of every policy of a run, and the index of the task that it was trained on last."""
    keys, count = files.policy_keys(document.protocol, group), len(group.tasks)
    order, numbers = task_order(document.protocol, document.run, count), [stage for stage, _ in keys]
    if document.protocol in IN_ORDER:
        return numbers, [order[stage - 1] if stage else None for stage in numbers]
    last = {"single": [*range(count)], "cumulative": [count - 1], "joint": [None]}
    return numbers, last[document.protocol]


def _diagnosed(
    folder: Path, group: TaskGroup, documents: Sequence[RunDocument]
) -> Iterator[tuple[Sequence[Diagnosis], str]]:
    """For every run the diagnoses of its policies, or empty ones and why."""
    known = diagnostics.load(folder, group)
    observations = states(group.task_ids)
    for document in documents:
        diagnoses: Sequence[Diagnosis] = ()
        why = "" if observations else "No observations of its tasks are published."
        if found := known.get(layout.run_key(group.name, document.protocol, document.run)):
            diagnoses = found.diagnoses
        elif document.policies and document.policies.url:
            why = "Its policies lie elsewhere."
        elif observations:
            place = document.protocol, document.run
            try:
                runs = runs_folder(folder, group.name, document.protocol)
                diagnoses = diagnose_run(files.read_policies(runs, group, *place), observations, *place)
            except BenchError as error:
                why = error.message
        yield diagnoses or [Diagnosis()] * len(files.policy_keys(document.protocol, group)), why


FEWEST_RUNS = 4
"""Of a group, for an interval over runs by the jackknife."""


def forgetting_predictors(policies: pd.DataFrame) -> pd.DataFrame:
    """Whether the change of a network since it learned a task predicts what it forgot of it at the end.

    Forgetting is the score of a task right after its training minus that after the last stage, for all tasks
    but the last. It is correlated (Spearman's ρ) with the difference between the two policies. ``across``:
    over all runs and tasks of a group; tasks that were learned earlier had more time to be forgotten.
    ``within``: over the runs alone, task by task (ranks among the runs, those of all tasks pooled).

    ==========  =======  ==========================================================================
    column      dtype    value
    ==========  =======  ==========================================================================
    submission  str      name of the submission's folder
    predictor   str      ``drift``, the KL on the observations of the task, or ``distances``
    kind        str      ``across`` (groups of three tasks or more) or ``within``
    groups      int64    number of groups with at least four sequential runs
    runs        int64    fewest runs of these groups
    mean        float64  mean correlation over these groups
    low, high   float64  ends of the 95 % interval over runs (jackknife)
    ==========  =======  ==========================================================================

    Args:
        policies: rows of :func:`policies`, for example of some groups. Runs that lack a stage are left out.
    """
    found: dict[tuple[str, str, str], list[Summary]] = {}
    for (name, _), frame in _whole_runs(policies, "parameters").groupby(["submission", "group"], sort=False):
        losses, *predictors = _changes(frame)
        for predictor, values in zip(("drift", "distances"), predictors, strict=True):
            complete = ~np.isnan(values + losses).any(axis=1)
            pair = values[complete], losses[complete]
            for kind in ("across", "within") if values.shape[1] > 1 else ("within",):
                if estimate := _correlation(*pair, is_within=kind == "within"):
                    found.setdefault((str(name), predictor, kind), []).append(estimate)
    rows = []
    for key, parts in found.items():
        each = to_interval(mean_of_groups(parts))
        rows.append((*key, len(parts), min(part.runs for part in parts), each.mean, each.low, each.high))
    return typed(rows, dtypes_of(forgetting_predictors))


def _whole_runs(policies: pd.DataFrame, known: str) -> pd.DataFrame:
    """The policies of the sequential runs of which the column has a value at every stage."""
    chosen = policies[(policies["protocol"] == "sequential") & policies[known].notna()]
    stages = chosen.groupby(["submission", "group", "run"])["stage"].transform("size")
    return chosen[stages == chosen["scores"].map(len) + 1]


def _changes(frame: pd.DataFrame) -> mlp_arrays.Array:
    """Forgetting, drift and distance at the end of the sequential runs of a group, (3, runs, tasks)."""
    rows = []
    for _, stages in frame.sort_values("stage").groupby("run"):
        scores, end = stages["scores"].tolist(), stages.iloc[-1]
        drift, distances = (end[name] or (math.nan,) * len(scores) for name in ("drift", "distances"))
        lost = [scores[task + 1][task] - scores[-1][task] for task in range(len(scores) - 2)]
        rows.append((lost, drift[: len(lost)], distances[1 : len(lost) + 1]))
    return np.array(rows).swapaxes(0, 1)


def _correlation(first: mlp_arrays.Array, second: mlp_arrays.Array, *, is_within: bool) -> Summary | None:
    """Spearman's ρ of (runs, tasks), over all values or over runs task by task; None if it is not defined.

    The standard error is that of the jackknife's pseudo-values, without each run.
    """

    def rho(runs: Sequence[int]) -> float:
        shape = (len(runs), -1) if is_within else (-1, 1)
        ranks = [pd.DataFrame(each[runs].reshape(shape)).rank().to_numpy() for each in (first, second)]
        x, y = (each - each.mean(axis=0) for each in ranks)
        norm = math.sqrt((x * x).sum() * (y * y).sum())
        return float((x * y).sum() / norm) if norm else math.nan

    runs = range(len(first))
    if len(runs) < FEWEST_RUNS or not first.size:
        return None
    whole, others = rho(list(runs)), [rho([run for run in runs if run != out]) for out in runs]
    if not all(map(math.isfinite, (whole, *others))):
        return None
    return replace(summary([whole + (len(runs) - 1) * (whole - other) for other in others]), mean=whole)


def network_changes(policies: pd.DataFrame) -> pd.DataFrame:
    """Whether the networks of a method lose rank, saturate or grow from the first task to the last one.

    ==========  =======  ==========================================================================
    column      dtype    value
    ==========  =======  ==========================================================================
    submission  str      name of the submission's folder
    measure     str      ``ranks`` or ``inactive`` of a hidden layer, or ``norms`` of any layer
    layer       int64    number of the layer, from 1
    groups      int64    number of groups, over which values are means
    runs        int64    fewest sequential runs of these groups
    untrained   float64  mean before training
    first       float64  mean after the first task
    last        float64  mean after the last task
    change      float64  mean of last − first
    low, high   float64  ends of its 95 % interval over runs; missing with one run
    ==========  =======  ==========================================================================

    Args:
        policies: rows of :func:`policies`, or some of them. Runs without a stage or a network are left out.
    """
    found: dict[tuple[str, str, int], list[pd.DataFrame]] = {}
    for (name, _), frame in _whole_runs(policies, "ranks").groupby(["submission", "group"], sort=False):
        for measure in ("ranks", "inactive", "norms"):
            known = frame[frame[measure].map(bool)]
            layers = pd.DataFrame(known[measure].tolist(), index=[known["run"], known["stage"]])
            for number, layer in enumerate(layers, 1):
                found.setdefault((str(name), measure, number), []).append(layers[layer].unstack())
    rows = []
    for key, groups in found.items():
        change = mean_of_groups([summary((each.iloc[:, -1] - each[1]).tolist()) for each in groups])
        means = (np.mean([each.iloc[:, stage].mean() for each in groups]) for stage in (0, 1, -1))
        ends = to_interval(change)
        rows.append((*key, len(groups), change.runs, *means, ends.mean, ends.low, ends.high))
    return typed(rows, dtypes_of(network_changes))
