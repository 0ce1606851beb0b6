"""Writes the audit sample of a submission, which its logs and a salt select."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.submission.lock import write_lock
from gym_extensions.baselines.submission.root import require_bound
from gym_extensions.baselines.submission.sample import trace_folders
from gym_extensions.baselines.tracing.episodes import StoredPolicies
from gym_extensions.baselines.training.progress import traces_folder
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.digests import trace_digest
from gym_extensions.rollouts.auditing.salt import parse_salt
from gym_extensions.rollouts.layout import PROGRESS, SALT_FILE, TRACE, TRACES
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.safe_npz import read as read_arrays
from gym_extensions.rollouts.submission import SubmittedGroup
from gym_extensions.rollouts.trace_reader import TraceRequest, trace_requests

STAGED = "traced"
"""The folder of the progress in which the traces are prepared."""


def trace(
    submission: str | Path, salt: str = "", *, groups: Iterable[str | Path | TaskGroup] = ()
) -> dict[str, int]:
    """Writes the traces of the audit sample that the logs and a salt select, and removes all others.

    A trace is taken from the recorder's folder ``.progress`` or from the submission. Where it is missing or
    damaged, the stored policy repeats the episodes of its cell. Every trace has the digest of its row in the
    log; if one cannot be obtained, the submission stays as it was.

    Args:
        submission: the submission's folder.
        salt: 64 hexadecimal digits that were fixed after the logs; empty for the sample without a salt.
        groups: custom groups that the submission may contain: TOML files or TaskGroup objects.

    Returns:
        The number of traces by group.

    Raises:
        BenchError: the salt is malformed, the submission has problems, a log commits to no traces, or a trace
            is neither stored nor repeated by its policy.
    """
    salt, folder, known = parse_salt(salt), Path(submission), with_custom(groups)
    content = read(folder, known)
    problems = [each for each in content.problems if not _is_trace(each.where)]
    if problems or content.manifest is None:
        reason = f"{problems[0].where}: {problems[0].message}" if problems else "It has no manifest."
        hint = f"Run: score {folder}"
        raise BenchError("not-valid", f"The submission has problems: {reason}", str(folder), hint)
    require_bound(folder)
    require_published_engine()
    with write_lock(folder), tempfile.TemporaryDirectory(prefix="gym-extensions-") as scratch:
        counts, staged = {}, Path(scratch) / STAGED
        policies = StoredPolicies(folder, content.manifest, Path(scratch))
        for submitted in content.groups.values():
            group, requests = submitted.group, list(_requests(folder, submitted, salt))
            folders = [*trace_folders(folder, group.name), traces_folder(Path(scratch), group.name)]
            for request in requests:
                write_bytes(staged / request.path, _find(folders, group, request, policies))
            counts[submitted.group.name] = len(requests)
        for name in counts:
            _replace(folder / name / TRACES, staged / name / TRACES, salt)
    return counts


def _is_trace(path: str) -> bool:
    """Whether a problem is that of a trace, which is written again."""
    return f"/{TRACES}/" in path and path.endswith(".npz")


def _requests(folder: Path, submitted: SubmittedGroup, salt: str) -> Iterator[TraceRequest]:
    for log in submitted.logs.values():
        yield from trace_requests(log, (folder / log.path).read_bytes(), salt)


def _find(
    folders: Sequence[Path], group: TaskGroup, request: TraceRequest, policies: StoredPolicies
) -> bytes:
    """The file of a trace with the logged digest, from the folders or from its policy."""
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
        hint = (
            "Run the command on the machine of the log and with its environment variables, such as "
            f"OPENBLAS_CORETYPE, or with the traces of all episodes in {PROGRESS}."
        )
        raise BenchError("policy-differs", message, request.path, hint)
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


def _replace(target: Path, staged: Path, salt: str) -> None:
    """Makes the folder of a group's traces contain the staged files, the salt and nothing else."""
    for path in staged.iterdir():
        write_bytes(target / path.name, path.read_bytes())
    if salt:
        write_bytes(target / SALT_FILE, f"{salt}\n".encode())
    expected = {path.name for path in staged.iterdir()} | ({SALT_FILE} if salt else set())
    for path in target.iterdir():
        if path.name not in expected:
            path.unlink()
