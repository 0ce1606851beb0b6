"""Finds the trace of a logged episode, or repeats the episode with its stored policy."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gym_extensions.baselines.tracing.episodes import StoredPolicies
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.digests import trace_digest
from gym_extensions.rollouts.layout import PROGRESS, TRACE
from gym_extensions.rollouts.safe_npz import read as read_arrays
from gym_extensions.rollouts.trace_reader import TraceRequest


def find_trace(
    folders: Sequence[Path], group: TaskGroup, request: TraceRequest, policies: StoredPolicies
) -> bytes:
    """The file of a trace with the logged digest.

    Args:
        folders: folders that may contain it.
        group: its group.
        request: the episode.
        policies: the policies, one of which repeats the episode if it is in no folder.

    Raises:
        BenchError: ``policy-differs`` if the policy gives another episode, ``traces-lost`` if there is none.
    """
    name = request.path.rpartition("/")[2]
    for path in folders:
        if (data := _matching(path / name, request)) is not None:
            return data
    match = TRACE.fullmatch(name)
    repeated = match and policies.traces(group, match[1], int(match[2]), int(match[3]), request.task)
    if repeated and (data := _matching(repeated / name, request)) is not None:
        return data
    if repeated:
        message = "The stored policy gives another episode than the log."
        raise BenchError("policy-differs", message, request.path)
    message = "The trace is not stored, and no stored policy can repeat it."
    hint = f"Restore the traces of all episodes in {PROGRESS}, or record the run again."
    raise BenchError("traces-lost", message, request.path, hint)


def _matching(path: Path, request: TraceRequest) -> bytes | None:
    """The bytes of a file if it is the trace to which the log commits."""
    if not path.is_file():
        return None
    data = path.read_bytes()
    arrays = read_arrays(data)
    outcome = (request.length, request.return_, request.terminated, request.success)
    return data if arrays is not None and trace_digest(arrays, *outcome) == request.digest else None
