"""Measures landscapes: runs stored policies in worlds between and beyond those of their training."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.groups import GROUPS, TaskGroup, group as group_named
from gym_extensions.catalog.protocol import evaluation_seed, stages
from gym_extensions.catalog.worlds import Axis, axes
from gym_extensions.envs.fingerprinting import engine, require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.submissions import landscapes, layout, reader
from gym_extensions.submissions.fetch import Fetcher
from gym_extensions.submissions.policies.files import AnyPolicy
from gym_extensions.submissions.run import ARITHMETIC, RunDocument
from gym_extensions.verification import episodes, limits, verify
from gym_extensions.versions import version

JOB = "gym_extensions.verification.landscape_recorder:measure"
LIMITS = limits.Limits(cpu_seconds=3600, wall_seconds=4 * 3600)
"""Of the process that measures one run."""
DIGITS = 1
"""Digits after the point of stored returns."""


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
    submission: Path, group: TaskGroup, documents: Mapping[int, RunDocument], fetcher: Fetcher, jobs: int = 1
) -> landscapes.Landscape | str:
    """The landscape of runs of a submission on a group with axes, measured now; or why there is none.

    Runs are measured ``jobs`` at once. Raises ``BenchError`` if the submission has problems, policies cannot
    be read or run, or a limit was reached.
    """
    if any(document.policies is None for document in documents.values()):
        return landscapes.NO_POLICIES
    found = reader.read(submission, only=[group.name])
    found.require_no_problems()
    known = verify.logged_runs(found)

    def work(run: int) -> list[Any]:
        name = layout.run_key(group.name, landscapes.PROTOCOL, run)
        request = known[name].request(found, fetcher=fetcher)
        return list(limits.answers(JOB, {"run": msgspec.to_builtins(request)}, LIMITS))

    with ThreadPoolExecutor(jobs) as pool:
        runs = np.array(list(pool.map(work, documents)))  # (runs, axes · stages, points, episodes)
    along = axes(group)
    return landscapes.Landscape(
        group=group.id,
        episodes=landscapes.EPISODES,
        policies={str(run): each.policies.sha256 for run, each in documents.items() if each.policies},
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
                returns=_rounded(part.mean(axis=-1)),
                deviations=_rounded(part.std(axis=-1)),
            )
            for axis, part in zip(along, np.split(runs, len(along), axis=1), strict=True)
        ),
    )


def _rounded(values: NDArray[np.float64]) -> tuple[Any, ...]:
    """Values (runs, stages, points) as nested tuples."""
    return tuple(tuple(tuple(round(x, DIGITS) for x in stage) for stage in run) for run in values.tolist())


def measure_all(
    submissions: Sequence[Path], names: Sequence[str], fetcher: Fetcher, jobs: int, again: bool
) -> Iterator[str]:
    """Measures the landscapes of submissions that are not up to date, or ``again``; yields a line about each.

    ``names`` are those of groups; all groups with axes if empty.

    Raises:
        BenchError: a group is unknown or has no worlds between its tasks, or a measurement fails. What was
            finished before is kept.
    """
    wanted = [group_named(name) for name in names] or [each for each in GROUPS.values() if axes(each)]
    for group in wanted:
        if not axes(group):
            hint = "Choose a gravity, body or wall group."
            raise BenchError("no-worlds", f"{group.name} varies no quantity.", "--groups", hint)
    for submission in submissions:
        for group in wanted:
            where = f"{submission.name}, {group.name}"
            if not (documents := landscapes.measured_runs(submission, group)):
                continue
            if not again and isinstance(landscapes.load(submission, group), landscapes.Landscape):
                yield f"{where}: up to date."
                continue
            found = landscape_of(submission, group, documents, fetcher, jobs)
            if isinstance(found, str):
                yield f"{where}: {found}"
                continue
            yield f"{landscapes.write(submission, found)}: {len(found.runs)} runs."
