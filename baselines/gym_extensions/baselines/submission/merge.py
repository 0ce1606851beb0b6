"""Joins submissions whose runs were trained on different machines."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.submission import folder, manifest
from gym_extensions.baselines.submission.merged_logs import merge_curves, merge_log
from gym_extensions.baselines.submission.merged_manifest import merged_tables, require_mergeable
from gym_extensions.baselines.submission.root import require_bound, traces_root
from gym_extensions.baselines.submission.sample import copy_traces, find_traces, sample_names, trace_folders
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import CURVES, EVALUATIONS, MANIFEST, POLICIES, SALT_FILE, TRACES
from gym_extensions.rollouts.reader import read

CustomGroups = Iterable[str | Path | TaskGroup]

PARTIAL = ("gaps-in-runs",)
"""Rules that a submission may break while further runs are to be merged into it."""


def merge(submissions: Iterable[str | Path], out: str | Path, *, groups: CustomGroups = ()) -> Path:
    """Joins submissions of one agent into a new one: their runs, curves, evaluations, traces and policies.

    The title, authors and description are those of the first. A run that several of them contain must be the
    same in all. The audit sample of a run depends on that run alone, so the submissions contain all traces
    that the new one needs. A run without traces stays without.

    Policies are merged if every submission has them.

    Args:
        submissions: the folders of two or more submissions.
        out: the folder of the new submission, which does not exist yet or is empty.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.

    Returns:
        ``out``.

    Raises:
        BenchError: a submission has problems; agents, budgets, hyperparameters or versions of the physics
            differ; two submissions contain different runs with the same number; a trace is missing; or
            ``out`` is not empty.

    Example:
        >>> merge(["machine-a/sac", "machine-b/sac"], "submissions/sac")  # doctest: +SKIP
    """
    paths = list(dict.fromkeys(map(Path, submissions)))
    if len(paths) < 2:
        raise BenchError("bad-merge", f"Expected two or more submissions, got {len(paths)}.")
    known = with_custom(groups)
    target = Path(out)
    folder.validate(target, known.values())
    if target.exists() and any(target.iterdir()):
        hint = "Choose a folder that does not exist yet."
        raise BenchError("bad-out", "The folder is not empty.", str(target), hint)
    for path in paths:
        _require_valid(path, path, known)
        require_bound(path)
    manifests = {path: manifest.read(path / MANIFEST) for path in paths}
    require_mergeable(manifests)
    folder.prepare(target.resolve().parent)
    partial = target.with_name(f".{target.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    try:
        staged = partial / target.name
        for name in sorted({item.name for path in paths for item in path.iterdir()} & known.keys()):
            _merge_group(paths, staged, known[name])
        tables = merged_tables(list(manifests.values())) | {"traces": {"root": traces_root(staged)}}
        manifest.write(staged / MANIFEST, tables)
        _require_valid(staged, target, known)
        if target.exists():
            target.rmdir()
        staged.replace(target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return target


def _require_valid(path: Path, shown: Path, groups: Mapping[str, TaskGroup]) -> None:
    submission = read(path, groups)
    problems = [problem for problem in submission.problems if problem.rule not in PARTIAL]
    if problems:
        first = problems[0]
        message = f"The submission would break the rule {first.rule}: {first.where}: {first.message}"
        if path == shown:
            message = f"The submission breaks the rule {first.rule}: {first.where}: {first.message}"
        raise BenchError("not-valid", message, str(shown), first.hint)
    if submission.manifest is None or submission.manifest.reported:
        raise BenchError("not-valid", "A reported entry has no logs to merge.", str(shown))


def _merge_group(paths: list[Path], staged: Path, group: TaskGroup) -> None:
    target = staged / group.name
    sources = [path / group.name for path in paths]
    salt = _common_salt([source for source in sources if source.exists()])
    for protocol in PROTOCOLS:
        logs = [source / f"{protocol}.csv" for source in sources if (source / f"{protocol}.csv").exists()]
        if not logs:
            continue
        text, owners = merge_log(logs)
        write_bytes(target / f"{protocol}.csv", text)
        copy_traces(_traces(group, protocol, text, owners, salt), target / TRACES, protocol)
        _copy_policies(logs, target / POLICIES, protocol)
    if salt:
        write_bytes(target / TRACES / SALT_FILE, f"{salt}\n".encode())
    for name in (CURVES, EVALUATIONS):
        curves = [source / name for source in sources if (source / name).exists()]
        if curves:
            write_bytes(target / name, merge_curves(curves))


def _common_salt(sources: list[Path]) -> str:
    """The salt of the traces of a group, empty if none drew them.

    Raises:
        BenchError: the salts differ.
    """
    salts = {
        source: path.read_text(encoding="ascii").strip() if path.exists() else ""
        for source in sources
        if any((source / TRACES).glob("*.npz"))
        for path in [source / TRACES / SALT_FILE]
    }
    if len(set(salts.values())) > 1:
        first, *others = salts
        message = f"The salts of the traces differ from those in {first}."
        other = next(source for source in others if salts[source] != salts[first])
        hint = "Run gym-extensions trace on both submissions, without a salt or with the same."
        raise BenchError("salted-traces", message, str(other / TRACES), hint)
    return next(iter(salts.values()), "")


def _traces(
    group: TaskGroup, protocol: str, text: bytes, owners: Mapping[int, Path], salt: str
) -> dict[str, Path]:
    """The traces of a merged log: the audit sample of the runs that have traces in their submission."""
    runs = [
        run
        for run, log in sorted(owners.items())
        if any((log.parent / TRACES).glob(f"{protocol}-run{run}-*.npz"))
    ]
    paths: dict[str, Path] = {}
    for name, run in sample_names(group, protocol, text, runs, salt).items():
        log = owners[run]
        folders = trace_folders(log.parents[1], group.name)
        paths |= find_traces({name: run}, folders, f"{group.name}/{log.name}")
    return paths


def _copy_policies(logs: list[Path], target: Path, protocol: str) -> None:
    """Copies the policies of a protocol. A log has all or none, so none if a submission has none."""
    policies = [sorted((log.parent / POLICIES).glob(f"{protocol}-*.npz")) for log in logs]
    if not all(policies):
        return
    for path in (path for paths in policies for path in paths):
        content, copy = path.read_bytes(), target / path.name
        if copy.exists() and copy.read_bytes() != content:
            message = f"Another submission has a different policy {path.name}."
            raise BenchError("different-run", message, str(path), "Leave that run out of one of them.")
        write_bytes(copy, content)
