"""Writes the audit sample of a submission, which its logs and a salt select."""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.submission.lock import write_lock
from gym_extensions.baselines.submission.merge import PARTIAL
from gym_extensions.baselines.submission.root import require_bound
from gym_extensions.baselines.submission.sample import trace_folders
from gym_extensions.baselines.submission.staging import staging
from gym_extensions.baselines.tracing.episodes import StoredPolicies
from gym_extensions.baselines.tracing.find import find_trace
from gym_extensions.baselines.training.progress import traces_folder
from gym_extensions.baselines.training.versions import UNKNOWN
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError
from gym_extensions.installed import blas_kernels
from gym_extensions.rollouts.auditing.salt import parse_salt
from gym_extensions.rollouts.layout import PROGRESS, SALT_FILE, TRACES
from gym_extensions.rollouts.manifest import RECORDED, Manifest
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.submission import Submission, SubmittedGroup
from gym_extensions.rollouts.trace_reader import TraceRequest, trace_requests


def trace(
    submission: str | Path,
    salt: str = "",
    *,
    groups: Iterable[str | Path | TaskGroup] = (),
    runs: Collection[int] | None = None,
) -> dict[str, int]:
    """Writes the traces of the audit sample that the logs and a salt select, and moves all others away.

    A trace is taken from the recorder's folder ``.progress`` or from the submission. Where it is missing or
    damaged, the stored policy repeats the episodes of its cell. Every trace has the digest of its row in the
    log. If one cannot be obtained, the submission stays as it was, and the repeated traces are kept in
    ``.progress``, so that a call with other BLAS kernels can repeat the others. Traces that leave the
    submission are kept there too.

    Args:
        submission: the submission's folder. Runs may be missing in it, as in a submission to be merged.
        salt: 64 hexadecimal digits that were fixed after the logs; empty for the sample without a salt.
        groups: custom groups that the submission may contain: TOML files or TaskGroup objects.
        runs: the runs whose traces are written; by default all. The other runs then have none, which suffices
            for a rank if all episodes were repeated (``gym-extensions repeat``).

    Returns:
        The number of traces by group.

    Raises:
        BenchError: the salt is malformed, the submission has problems, no log has one of the runs, a log
            commits to no traces, or a trace is neither stored nor repeated by its policy.
    """
    salt, folder, known = parse_salt(salt), Path(submission), with_custom(groups)
    _read(folder, known)  # before the lock, whose file belongs only into a submission
    require_published_engine()
    with write_lock(folder), tempfile.TemporaryDirectory(prefix="gym-extensions-") as scratch:
        content, manifest = _read(folder, known)
        _require_runs(runs or (), content)
        policies = StoredPolicies(folder, manifest, Path(scratch))
        with staging(folder) as staged:
            groups_by_name = {each.group.name: each.group for each in content.groups.values()}
            requests = {
                each.group.name: [
                    request
                    for request in _requests(folder, each, salt)
                    if runs is None or request.run in runs
                ]
                for each in content.groups.values()
            }
            failures: list[BenchError] = []
            try:
                for name, each in requests.items():
                    folders = [*trace_folders(folder, name), traces_folder(Path(scratch), name)]
                    failures += _stage(each, staged, folders, groups_by_name[name], policies)
                if failures:
                    raise _unfinished(failures, manifest)
                _replace(folder, staged, requests, salt)
            except BaseException:
                _keep(staged, folder)
                raise
    return {name: len(each) for name, each in requests.items()}


def _read(folder: Path, groups: Mapping[str, TaskGroup]) -> tuple[Submission, Manifest]:
    """The submission, every run for itself. Raises ``BenchError`` if it has problems or names no traces."""
    content = read(folder, groups, merge_runs=False)
    problems = [
        problem
        for problem in content.problems
        if problem.rule not in PARTIAL and not _is_trace(problem.where)
    ]
    if problems or content.manifest is None:
        reason = f"{problems[0].where}: {problems[0].message}" if problems else "It has no manifest."
        hint = f"Run: score {folder}"
        raise BenchError("not-valid", f"The submission has problems: {reason}", str(folder), hint)
    require_bound(folder)
    return content, content.manifest


def _require_runs(runs: Collection[int], submission: Submission) -> None:
    """Raises ``BenchError`` if no log has one of the runs."""
    known = {run for group in submission.groups.values() for log in group.logs.values() for run in log.runs}
    if unknown := sorted(set(runs) - known):
        hint = f"Choose from: {', '.join(map(str, sorted(known)))}."
        raise BenchError("no-run", f"Run {unknown[0]} is not in the logs.", "--runs", hint)


def _stage(
    requests: Iterable[TraceRequest],
    staged: Path,
    folders: Sequence[Path],
    group: TaskGroup,
    policies: StoredPolicies,
) -> Iterator[BenchError]:
    """Writes the traces of a group to the folder ``staged``.

    Yields an error per policy that does not repeat its episodes, and leaves out its other traces.
    """
    failed = set[str]()
    for request in requests:
        if request.policy in failed:
            continue
        try:
            write_bytes(staged / request.path, find_trace(folders, group, request, policies))
        except BenchError as error:
            failed.add(request.policy)
            yield error


def _is_trace(path: str) -> bool:
    """Whether a problem is that of a trace, which is written again."""
    return f"/{TRACES}/" in path and path.endswith(".npz")


def _requests(folder: Path, submitted: SubmittedGroup, salt: str) -> Iterator[TraceRequest]:
    for log in submitted.logs.values():
        yield from trace_requests(log, (folder / log.path).read_bytes(), salt)


def _keep(staged: Path, folder: Path) -> None:
    """Moves the staged traces to the recorder's folder of all episodes, where the next call finds them."""
    for path in staged.rglob("*.npz"):
        target = traces_folder(folder, path.parents[1].name) / path.name
        target.parent.mkdir(parents=True, exist_ok=True)
        path.replace(target)


def _unfinished(failures: Sequence[BenchError], manifest: Manifest) -> BenchError:
    """The first error, with the number of policies that failed and what may help."""
    first, protocol = failures[0], manifest.protocol
    kept = f"What could be repeated is kept in {PROGRESS}."
    if len(failures) > 1:
        kept = f"The same holds for {len(failures) - 1} more policies. {kept}"
    if first.code != "policy-differs":
        return BenchError(first.code, first.message, first.where, f"{kept} {first.hint}")
    restore = f"restore the traces of all episodes in {PROGRESS}."
    made = (manifest.versions and manifest.versions.blas) or UNKNOWN
    if protocol.evaluation == "sampled" and protocol.steps == RECORDED:
        hint = f"The agent samples its actions, which its policy cannot repeat: {restore}"
    elif made == blas_kernels():
        hint = restore.capitalize()
    else:
        hint = (
            f"The log was made with the BLAS kernels {made}, and this process has {blas_kernels()}. Run the "
            f"command again with those of the log, which OPENBLAS_CORETYPE can choose, or {restore}"
        )
    return BenchError(first.code, first.message, first.where, f"{kept} {hint}")


def _replace(folder: Path, staged: Path, requests: Mapping[str, Sequence[TraceRequest]], salt: str) -> None:
    """Makes the folders of the traces contain the requested ones, the salt and nothing else.

    Other traces are moved to the recorder's folder, because a policy may be unable to repeat them.
    """
    for name, each in requests.items():
        if salt and each:
            write_bytes(staged / name / TRACES / SALT_FILE, f"{salt}\n".encode())
    expected = {path.relative_to(staged) for path in staged.rglob("*") if path.is_file()}
    for path in sorted(expected):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (staged / path).replace(folder / path)
    for name in requests:
        for path in (folder / name / TRACES).glob("*"):
            if path.relative_to(folder) in expected:
                continue
            kept = traces_folder(folder, name) / path.name
            if path.name == SALT_FILE or kept.exists():
                path.unlink()
            else:
                kept.parent.mkdir(parents=True, exist_ok=True)
                path.replace(kept)
