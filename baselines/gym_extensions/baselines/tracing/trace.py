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
from gym_extensions.baselines.training.versions import blas_kernels
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.digests import trace_digest
from gym_extensions.rollouts.auditing.salt import parse_salt
from gym_extensions.rollouts.layout import PROGRESS, SALT_FILE, TRACE, TRACES
from gym_extensions.rollouts.manifest import Manifest
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
    log. If one cannot be obtained, the submission stays as it was, and the repeated traces are kept in
    ``.progress``, so that a call with other BLAS kernels can repeat the others.

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
        staged = Path(scratch) / STAGED
        policies = StoredPolicies(folder, content.manifest, Path(scratch))
        counts, failures = {}, list[BenchError]()
        for submitted in content.groups.values():
            requests = list(_requests(folder, submitted, salt))
            repeated = traces_folder(Path(scratch), submitted.group.name)
            folders = [*trace_folders(folder, submitted.group.name), repeated]
            failures += _stage(requests, staged, folders, submitted.group, policies)
            counts[submitted.group.name] = len(requests)
        if failures:
            kept = sum(_keep(staged / name / TRACES, traces_folder(folder, name)) for name in counts)
            raise _unfinished(failures[0], kept, sum(counts.values()), content.manifest)
        for name in counts:
            _replace(folder / name / TRACES, staged / name / TRACES, salt)
    return counts


def _stage(
    requests: Iterable[TraceRequest],
    staged: Path,
    folders: Sequence[Path],
    group: TaskGroup,
    policies: StoredPolicies,
) -> Iterator[BenchError]:
    """Writes the traces of a group to the folder ``staged``. Yields an error per run that lacks one.

    The remaining traces of such a run are left out: one process recorded all of them.
    """
    failed = set[tuple[str, ...]]()
    for request in requests:
        name = TRACE.fullmatch(_name(request))
        run = name.groups()[:2] if name else ()
        if run in failed:
            continue
        try:
            write_bytes(staged / request.path, _find(folders, group, request, policies))
        except BenchError as error:
            failed.add(run)
            yield error


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
    name = _name(request)
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
            "Run the command again with the BLAS kernels of the log (OPENBLAS_CORETYPE can choose them), "
            f"or with the traces of all episodes in {PROGRESS}."
        )
        raise BenchError("policy-differs", message, request.path, hint)
    message = "The trace is not stored, and no stored policy can repeat it."
    hint = f"Restore the traces of all episodes in {PROGRESS}, or record the run again."
    raise BenchError("traces-lost", message, request.path, hint)


def _name(request: TraceRequest) -> str:
    return request.path.rpartition("/")[2]


def _keep(staged: Path, target: Path) -> int:
    """Copies the traces that could be obtained to the recorder's folder. Returns their number."""
    paths = list(staged.glob("*.npz"))
    for path in paths:
        write_bytes(target / path.name, path.read_bytes())
    return len(paths)


def _unfinished(error: BenchError, kept: int, total: int, manifest: Manifest) -> BenchError:
    """The first error, with the number of traces that are kept and the BLAS kernels."""
    made = manifest.versions.blas if manifest.versions else ""
    kernels = f"The log was made with {made or 'unknown BLAS kernels'}; this process has {blas_kernels()}."
    hint = f"{kept} of {total} traces are kept in {PROGRESS}. {kernels} {error.hint}"
    return BenchError(error.code, error.message, error.where, hint)


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
