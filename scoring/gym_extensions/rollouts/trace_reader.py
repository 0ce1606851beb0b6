"""Reads and checks the traces of a submission's audit sample."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.auditing.digests import trace_digest
from gym_extensions.rollouts.auditing.salt import salt_of
from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.auditing.trace_errors import trace_errors
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import POLICIES, SALT_FILE, TRACE, TRACES, policy_name, trace_name
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.safe_npz import read
from gym_extensions.rollouts.submission import Evidence, SubmittedGroup
from gym_extensions.rollouts.traces import ACTIONS, SEGMENT_RETURNS, STATE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TraceRequest:
    """An episode of the audit sample, with its row of the log and the path of its trace.

    ``policy`` is the path of the policy that recorded it; ``task_index`` is the task's index in the group;
    ``digest`` is that of the trace in the log.
    """

    path: str
    task: Task
    seed: int
    length: int
    return_: float
    terminated: bool
    success: bool | None
    policy: str = ""
    task_index: int = 0
    digest: str = ""
    run: int = 0


@dataclass(frozen=True)
class RecordedEpisode:
    """An episode to replay.

    ``actions`` (L, …) float32; ``returns`` (S,) the recorded return of each segment of K steps; ``states`` by
    name, (S − 1, …): the state one step before each segment but the first. ``policy`` is that of its stage,
    None if the submission has none, and ``task_index`` the task's index in the group.
    """

    where: str
    task: Task
    seed: int
    length: int
    terminated: bool
    success: bool | None
    actions: NDArray[np.float32]
    returns: Array
    states: dict[str, Array]
    policy: Policy | None = None
    task_index: int = 0

    @property
    def segment_steps(self) -> int:
        """K."""
        return self.task.body.segments.steps


def salt_in(folder: Folder, group_name: str) -> str:
    """The salt that drew the traces of a group, empty without one. The rules of its file have passed."""
    path = f"{group_name}/{TRACES}/{SALT_FILE}"
    return salt_of(folder.read(path)) or "" if path in folder.files else ""


def with_evidence(submitted: SubmittedGroup, folder: Folder) -> SubmittedGroup:
    """The group without problems, with what the traces of each log cover."""
    salt, evidence = salt_in(folder, submitted.group.name), {}
    for protocol, log in submitted.logs.items():
        requests = list(trace_requests(log, folder.read(log.path), salt))
        missing = sum(request.path not in folder.files for request in requests)
        evidence[protocol] = Evidence(len(requests), missing, salt)
    return replace(submitted, evidence=evidence)


def requests_with_traces(log: Log, folder: Folder, salt: str = "") -> list[TraceRequest]:
    """The episodes of a log's audit sample in runs that have traces. A run has all of its sample or none.

    Args:
        log: a log without problems.
        folder: its submission.
        salt: what draws the sample, or empty.
    """
    prefix = f"{log.group.name}/{TRACES}/"
    names = (path.removeprefix(prefix) for path in folder.files if path.startswith(prefix))
    matches = filter(None, map(TRACE.fullmatch, names))
    runs = {int(match[2]) for match in matches if match[1] == log.protocol}
    if not runs:
        return []
    requests = trace_requests(log, folder.read(log.path), salt)
    return [request for request in requests if request.run in runs]


def trace_requests(log: Log, data: bytes, salt: str = "") -> Iterator[TraceRequest]:
    """The episodes of a log's audit sample; none if the log commits to no traces.

    Args:
        log: a log without problems.
        data: the bytes of its file, which select the sample.
        salt: what draws the sample, or empty.
    """
    if not log.trace:
        return
    indices = {key: index for index, key in enumerate(log.episode_keys)}
    for audited in audit_sample(log.protocol, data, log.runs, log.group.tasks, salt):
        yield _request(log, indices[audited.run, audited.stage, audited.task, audited.episode])


def all_requests(log: Log) -> Iterator[TraceRequest]:
    """All episodes of a log that commits to traces, in the order of its rows."""
    return (_request(log, index) for index in range(len(log.trace)))


def _request(log: Log, index: int) -> TraceRequest:
    run, stage, task_index = int(log.run[index]), int(log.stage[index]), int(log.position[index])
    task, folder = log.group.tasks[task_index], log.group.name
    name = trace_name(log.protocol, run, stage, task.name, int(log.episode[index]))
    return TraceRequest(
        f"{folder}/{TRACES}/{name}",
        task,
        int(log.seed[index]),
        int(log.length[index]),
        float(log.return_[index]),
        bool(log.terminated[index]),
        None if log.success[index] < 0 else bool(log.success[index]),
        f"{folder}/{POLICIES}/{policy_name(log.protocol, run, stage, task.name)}",
        task_index,
        log.trace[index],
        run,
    )


def read_trace(folder: Folder, request: TraceRequest) -> RecordedEpisode | Problem:
    """The episode with its trace, or the first problem of the trace."""
    if request.path not in folder.files:
        hint = "Run gym-extensions trace on the folder, or add the trace (docs/rollout-log.md)."
        return Problem("trace-missing", request.path, "The audit sample needs this trace.", hint)
    try:
        arrays = read(folder.read(request.path))
    except OSError:
        arrays = None
    error = (
        "The file cannot be read."
        if arrays is None
        else next(trace_errors(arrays, request.task, request.length, request.return_), "")
    )
    if arrays is None or error:
        hint = "Delete the file and run gym-extensions trace, or record the trace (docs/rollout-log.md)."
        return Problem("trace-malformed", request.path, error, hint)
    outcome = (request.length, request.return_, request.terminated, request.success)
    if trace_digest(arrays, *outcome) != request.digest:
        message = "The log commits to another trace of this episode."
        hint = "Include the trace that was recorded with the log; a log that was changed has other traces."
        return Problem("trace-differs", request.path, message, hint)
    return RecordedEpisode(
        request.path,
        request.task,
        request.seed,
        request.length,
        request.terminated,
        request.success,
        arrays[ACTIONS],
        arrays[SEGMENT_RETURNS],
        {name.removeprefix(STATE): values for name, values in arrays.items() if name.startswith(STATE)},
        task_index=request.task_index,
    )
