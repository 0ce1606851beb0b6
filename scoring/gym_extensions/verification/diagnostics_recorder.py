"""Computes diagnostics: stored policies on the published observations of their tasks."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.catalog.groups import GROUPS, TaskGroup, group as group_named
from gym_extensions.catalog.states import states
from gym_extensions.errors import BenchError
from gym_extensions.submissions import diagnostics, fetch, reader
from gym_extensions.submissions.diagnostics import Diagnosis, diagnose_run
from gym_extensions.verification import episodes, limits, verify

JOB = "gym_extensions.verification.diagnostics_recorder:work"
DIGITS = 5
"""Significant digits of stored numbers; later ones depend on the machine's linear algebra."""


def work(call: Mapping[str, Any]) -> Iterator[Any]:
    """The job of the process with limits: the diagnoses of each run of a group, or why there are none."""
    requests = msgspec.convert(call["runs"], list[episodes.RunRequest])
    group = GROUPS[requests[0].group]
    observations = states(group.task_ids) or []
    for request in requests:
        try:
            policies = episodes.stored_policies(request, group)
            found = diagnose_run(policies, observations, request.protocol, request.run)
            yield _rounded(msgspec.to_builtins(found))
        except BenchError as error:
            yield error.message


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _rounded(each) for name, each in value.items()}
    if isinstance(value, tuple | list):
        return [_rounded(each) for each in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def measure_all(
    submissions: Sequence[Path], names: Sequence[str], fetcher: fetch.Fetcher, jobs: int, again: bool
) -> Iterator[str]:
    """Writes the diagnostics of submissions that are not up to date, or ``again``; yields a line about each.

    ``names`` are those of groups; all groups with published observations if empty. A run whose policies do
    not fit the observations gets a line that says so, and no diagnostics.

    Raises:
        BenchError: a group is unknown or its tasks have no published observations, a submission has problems,
            or a limit was reached. What was finished before is kept.
    """
    observed = [each for each in GROUPS.values() if states(each.task_ids)]
    wanted = [group_named(name) for name in names] or observed
    for group in wanted:
        if group not in observed:
            message = f"No observations of {group.name} are published."
            raise BenchError("no-states", message, "--groups", "Run: python -m tools.environments")
    there = [(each, group) for each in submissions for group in wanted if (each / group.name).is_dir()]
    with ThreadPoolExecutor(jobs) as pool:
        for lines in pool.map(lambda pair: _measure(pair[0], pair[1], fetcher, again), there):
            yield from lines


def _measure(submission: Path, group: TaskGroup, fetcher: fetch.Fetcher, again: bool) -> list[str]:
    """Writes the diagnostics of one group and returns the lines about it."""
    found = reader.read(submission, only=[group.name])
    found.require_no_problems()
    logged = {name: run for name, run in verify.logged_runs(found).items() if run.document.policies}
    if not again and len(diagnostics.load(submission, group)) == len(logged):
        return [f"{submission.name}, {group.name}: up to date."]
    requests = [run.request(found, fetcher=fetcher) for run in logged.values()]
    answers = limits.answers(JOB, {"runs": msgspec.to_builtins(requests)}, limits.Limits())
    runs, lines = dict[str, diagnostics.DiagnosedRun](), list[str]()
    for request, answer in zip(requests, answers, strict=True):
        if isinstance(answer, str):
            lines.append(f"{submission.name}, {request.name}: {answer}")
        else:
            diagnoses = msgspec.convert(answer, tuple[Diagnosis, ...])
            runs[request.name] = diagnostics.DiagnosedRun(request.policies, diagnoses)
    return [*lines, f"{diagnostics.write(submission, group, runs)}: {len(runs)} runs."] if runs else lines
