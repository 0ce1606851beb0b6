"""Runs stored policies for documents of a submission: poses, landscapes and diagnostics.

Poses are the motion of logged episodes. A landscape is measured in worlds between and beyond those of the
training, diagnostics on the published observations of the tasks.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import fmean
from typing import Any

import msgspec
import numpy as np

from gym_extensions.catalog.groups import GROUPS, TaskGroup, group as group_named
from gym_extensions.catalog.protocol import evaluation_seed, stages
from gym_extensions.catalog.states import VERSION, states
from gym_extensions.catalog.worlds import Axis, axes
from gym_extensions.envs.fingerprinting import engine, require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.submissions import diagnostics, landscapes, layout, poses, reader
from gym_extensions.submissions.fetch import Fetcher
from gym_extensions.submissions.policies.diagnostics import Diagnosis, diagnose_run
from gym_extensions.submissions.policies.files import AnyPolicy
from gym_extensions.submissions.problem import refuse_problems
from gym_extensions.submissions.run import ARITHMETIC
from gym_extensions.verification import episodes, limits, pose_recorder
from gym_extensions.verification.logged_run import LoggedRun, logged_runs
from gym_extensions.versions import version

RETURN, DIAGNOSIS = ".1f", ".5g"
"""Digits of stored numbers; later ones of diagnostics depend on the machine's linear algebra."""
REFUSALS = {
    "landscapes": ("no-worlds", "{} varies no quantity.", "Choose a gravity, body or wall group."),
    "diagnostics": ("no-states", "No observations of {} are published.", "Run: python -m tools.environments"),
}
"""The error for a group that cannot be measured: its code, message and hint."""


def _rounded(value: Any, digits: str) -> Any:
    """A number, or all numbers in dictionaries and sequences, which become tuples."""
    if isinstance(value, dict):
        return {name: _rounded(each, digits) for name, each in value.items()}
    if isinstance(value, tuple | list):
        return tuple(_rounded(each, digits) for each in value)
    return float(format(value, digits)) if isinstance(value, float) else value


def _published(submission: Path, group: TaskGroup) -> dict[str, LoggedRun]:
    """The runs of a group that publish their policies, by name.

    Raises the first problem.
    """
    found = reader.read(submission, only=[group.name])
    refuse_problems(submission, found.problems)
    return {
        name: run
        for source in found.sources
        for name, run in logged_runs(source).items()
        if run.document.policies
    }


def write(
    kind: str,
    submissions: Sequence[Path],
    names: Sequence[str],
    fetcher: Fetcher,
    jobs: int,
    *,
    again: bool,
) -> Iterator[str]:
    """Writes the documents of submissions that are not up to date, or ``again``; yields a line about each.

    ``kind`` is ``poses``, ``landscapes`` or ``diagnostics``. ``names`` are those of groups; all that can be
    measured if empty. ``jobs`` processes work at once.

    Raises:
        BenchError: a group is unknown or cannot be measured, a submission has problems, policies cannot be
            run, or a limit was reached. What was finished before is kept.
    """
    measurable = {
        "poses": [*GROUPS.values()],
        "landscapes": [group for group in GROUPS.values() if axes(group)],
        "diagnostics": [group for group in GROUPS.values() if states(group.task_ids)],
    }[kind]
    groups = [group_named(name) for name in names] or measurable
    for group in groups:
        if group not in measurable:
            code, message, hint = REFUSALS[kind]
            raise BenchError(code, message.format(group.name), "--groups", hint)
    pairs = [
        (submission, group)
        for submission in submissions
        for group in groups
        if (submission / group.name).is_dir() or any(submission.glob(f"{layout.TRAINED}/*/{group.name}"))
    ]
    writers: dict[str, Callable[..., list[str]]] = {
        "poses": write_poses,
        "landscapes": write_landscape,
        "diagnostics": write_diagnostics,
    }
    with ThreadPoolExecutor(jobs) as pool:
        for lines in pool.map(lambda pair: writers[kind](*pair, fetcher, again=again), pairs):
            yield from lines


def write_poses(submission: Path, group: TaskGroup, fetcher: Fetcher, *, again: bool) -> list[str]:
    """Records the first sequential run that publishes its policies, and says so in a line."""
    where, published = f"{submission.name}, {group.name}", _published(submission, group).values()
    run = next((each for each in published if each.log.protocol == "sequential"), None)
    if run is None:
        return [f"{where}: no sequential run publishes its policies."]
    known, tasks = poses.load_submission(submission).get(group.id), range(len(group.tasks))
    means = {key: fmean(each.return_ for each in cell) for key, cell in run.logged.items()}
    matrix = tuple(tuple(means[stage, task] for task in tasks) for stage in range(len(group.tasks) + 1))
    if not again and known is not None and known.shows((run.document.run,), (matrix,)):
        return [f"{where}: up to date."]
    recorded = pose_recorder.poses_of(run, fetcher)
    path = recorded.write(submission / layout.POSES / f"{group.name}.json")
    return [f"{path}: run {run.document.run}."]


def returns_of(group: TaskGroup, policy: AnyPolicy, axis: Axis, stage: int, run: int) -> list[list[float]]:
    """The returns [point][episode] of the policy of a stage in the worlds of an axis, one after another."""
    returns = []
    seeds = tuple(evaluation_seed(group.id, "landscape", episode) for episode in range(landscapes.EPISODES))
    for point, value in enumerate(axis.points):
        where = f"landscape/{axis.name}/{point}/run{run}/stage{stage}"
        cell = episodes.Cell(stage, axis.nearest(value), seeds, evaluation_seed(group.id, where, 0))
        outcomes = episodes.run_cell(group, policy, cell, world=axis.world(value))
        returns.append([outcome.return_ for outcome in outcomes])
    return returns


def measure(call: Mapping[str, Any]) -> Iterator[Any]:
    """The job of the process with limits: returns [axis][stage][point][episode] of one run."""
    require_published_engine()
    request = msgspec.convert(call["run"], episodes.RunRequest)
    group = GROUPS[request.group]
    policies = episodes.stored_policies(request, group)
    for axis in axes(group):
        for stage in stages(landscapes.PROTOCOL, len(group.tasks)):
            yield returns_of(group, policies[stage, None], axis, stage, request.run)


def landscape_of(
    submission: Path, group: TaskGroup, runs: Iterable[int], fetcher: Fetcher
) -> landscapes.Landscape:
    """The landscape of runs of a submission on a group with axes, measured now, one run after another.

    Raises ``BenchError`` if the submission has problems, policies cannot be read or run, or a limit was
    reached.
    """
    names = [layout.run_key(group.name, landscapes.PROTOCOL, run) for run in runs]
    published = _published(submission, group)
    requests = [published[name].request(fetcher=fetcher) for name in names]
    limit = limits.Limits(cpu_seconds=3600, wall_seconds=4 * 3600)  # of the process for one run
    calls = ({"run": msgspec.to_builtins(request)} for request in requests)
    # (runs, axes · stages, points, episodes)
    returns = np.array([list(limits.answers(measure, call, limit)) for call in calls])
    along = axes(group)
    return landscapes.Landscape(
        group=group.id,
        episodes=landscapes.EPISODES,
        policies={str(request.run): request.policies for request in requests},
        versions={
            **engine(),
            "numpy": version("numpy"),
            "gym_extensions": version("gym-extensions"),
            "arithmetic": str(ARITHMETIC),
        },
        axes=tuple(
            landscapes.MeasuredAxis(
                name=axis.name,
                points=axis.points,
                returns=_rounded(part.mean(axis=-1).tolist(), RETURN),
                deviations=_rounded(part.std(axis=-1).tolist(), RETURN),
            )
            for axis, part in zip(along, np.split(returns, len(along), axis=1), strict=True)
        ),
    )


def write_landscape(submission: Path, group: TaskGroup, fetcher: Fetcher, *, again: bool) -> list[str]:
    """Measures the landscape of a group with axes, and says so in a line; none without runs to measure."""
    where, documents = f"{submission.name}, {group.name}", landscapes.measured_runs(submission, group)
    if not documents:
        return []
    if not again and isinstance(landscapes.load(submission, group), landscapes.Landscape):
        return [f"{where}: up to date."]
    if any(document.policies is None for document in documents.values()):
        return [f"{where}: {landscapes.NO_POLICIES}"]
    found = landscape_of(submission, group, documents, fetcher)
    return [f"{found.write(landscapes.path_of(submission, group))}: {len(found.runs)} runs."]


def diagnose(call: Mapping[str, Any]) -> Iterator[Any]:
    """The job of the process with limits: the diagnoses of each run of a group, or why there are none."""
    requests = msgspec.convert(call["runs"], list[episodes.RunRequest])
    group = GROUPS[requests[0].group]
    observations = states(group.task_ids) or []
    for request in requests:
        try:
            policies = episodes.stored_policies(request, group)
            found = diagnose_run(policies, observations, request.protocol, request.run)
            yield _rounded(msgspec.to_builtins(found), DIAGNOSIS)
        except BenchError as error:
            yield error.message


def write_diagnostics(submission: Path, group: TaskGroup, fetcher: Fetcher, *, again: bool) -> list[str]:
    """Computes the diagnostics of a group, and returns the lines about it.

    A run whose policies do not fit the observations gets a line that says so, and no diagnostics.
    """
    published = _published(submission, group)
    if not published:
        return [f"{submission.name}, {group.name}: no run publishes its policies."]
    if not again and len(diagnostics.load(submission, group)) == len(published):
        return [f"{submission.name}, {group.name}: up to date."]
    requests = [run.request(fetcher=fetcher) for run in published.values()]
    call = {"runs": msgspec.to_builtins(requests)}
    runs, lines = dict[str, diagnostics.DiagnosedRun](), list[str]()
    answers = limits.answers(diagnose, call, limits.Limits())
    for request, answer in zip(requests, answers, strict=True):
        if isinstance(answer, str):
            lines.append(f"{submission.name}, {request.name}: {answer}")
        else:
            diagnoses = msgspec.convert(answer, tuple[Diagnosis, ...])
            runs[request.name] = diagnostics.DiagnosedRun(request.policies, diagnoses)
    if runs:
        found = diagnostics.Diagnostics(group=group.id, states=VERSION, runs=runs)
        lines.append(f"{found.write(diagnostics.path_of(submission, group))}: {len(runs)} runs.")
    return lines
