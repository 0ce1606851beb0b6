"""A submission that has been read, and its runs that are identical in every episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout, problem
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.manifest import Manifest
from gym_extensions.submissions.review import Review
from gym_extensions.submissions.run import Memory, RunDocument, consecutive
from gym_extensions.submissions.training import Training

TOLERANCE = 1e-5
"""Largest difference of identical returns, absolute and relative: a copy with noise is the same run."""
PAIRED_PROTOCOLS = (("sequential", "single"), ("joint",), ("cumulative",), ("descending",), ("balanced",))
"""Protocols whose runs belong together: a run of one agent has both a sequential and a single log."""


@dataclass(frozen=True, repr=False)
class SubmittedGroup:
    """A group of a submission.

    ``logs`` are those without problems, by protocol; ``runs`` are the documents of their runs, by protocol
    and run. ``notes`` are sentences for the reader of the submission.
    """

    group: TaskGroup
    logs: dict[str, Log]
    runs: dict[str, dict[int, RunDocument]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        runs = {protocol: log.runs for protocol, log in self.logs.items()}
        return f"SubmittedGroup({self.group.name!r}, runs={runs})"

    def digests(self, protocol: str) -> dict[str, str]:
        """What verifications of a log are about: the digest of each run, by its name in review.toml."""
        runs = self.logs[protocol].runs
        documents = self.runs[protocol]
        return {layout.run_key(self.group.name, protocol, run): documents[run].digest for run in runs}


@dataclass(frozen=True, repr=False)
class Submission:
    """A submission. With problems, it holds what could be read.

    ``groups`` are by group id, with all runs; ``readme`` is the text of README.md with ``\\n`` line ends,
    empty without one; ``review`` is what the base branch found out; ``path`` is the folder that was read;
    ``code`` is the digest of its code, empty without any, and ``trained`` what the base trained of it.
    """

    name: str
    manifest: Manifest | None
    groups: dict[str, SubmittedGroup]
    problems: tuple[problem.Problem, ...] = ()
    readme: str = ""
    review: Review = field(default_factory=Review)
    path: Path = Path()
    code: str = ""
    trained: Trained | None = None

    def __repr__(self) -> str:
        return f"Submission({self.name!r}, groups={list(self.groups)}, {len(self.problems)} problems)"

    def require_no_problems(self) -> None:
        """Raises the first problem as a ``BenchError``."""
        for each in self.problems:
            raise BenchError(each.rule, each.message, f"{self.name}: {each.where}", each.hint)

    @property
    def documents(self) -> list[RunDocument]:
        """The documents of all runs, by group, protocol and run."""
        runs = (documents for group in self.groups.values() for documents in group.runs.values())
        return [document for documents in runs for document in documents.values()]

    @property
    def memory(self) -> Memory | None:
        """The largest memory of all runs; None without runs."""
        parts = [msgspec.structs.astuple(document.memory) for document in self.documents]
        largest = map(max, zip(*parts, strict=True))
        return Memory(**dict(zip(Memory.__struct_fields__, largest, strict=True))) if parts else None


@dataclass(frozen=True)
class Trained:
    """What the base branch trained: the number of the version of the code, the record, and the runs."""

    version: int
    training: Training
    runs: Submission


def is_trainable(runs: Mapping[str, Mapping[int, RunDocument]]) -> bool:
    """Whether the agent has parameters to train; True if there is no document that says so."""
    documents = [document for parts in runs.values() for document in parts.values()]
    return not documents or any(document.memory.parameters_last > 0 for document in documents)


def scored_runs(submission: Submission) -> Submission:
    """The submission with the runs that are scored; unchanged if it has problems.

    In each group, identical runs of an agent without parameters count as one (:func:`scored_group`).
    """
    if submission.problems:
        return submission
    groups = {
        name: scored_group(group, merge=not is_trainable(group.runs))
        for name, group in submission.groups.items()
    }
    return replace(submission, groups=groups)


def scored_group(submitted: SubmittedGroup, *, merge: bool) -> SubmittedGroup:
    """The group with the runs that are scored, and notes: on each set of the others, and on unequal logs.

    They are the runs 0 to N − 1 of each log, up to the first gap. With ``merge``, identical runs count as
    one. A sequential and a single run of one training seed are a pair; two pairs are identical if both logs
    are, or the one that both have. Joint and cumulative runs are compared by themselves.
    """
    logs, notes = dict(submitted.logs), list[str]()
    for protocol, log in submitted.logs.items():
        count = consecutive(log.runs)
        if later := [run for run in log.runs if run > count]:
            logs[protocol] = select_runs(log, set(range(count)))
            runs = ", ".join(map(str, later))
            notes.append(f"{protocol}: run {count} is missing; until it is there, not scored: {runs}.")
    for protocols in PAIRED_PROTOCOLS if merge else ():
        first_runs = [first_identical_runs(logs[name]) for name in protocols if name in logs]
        sets: dict[tuple[int | None, ...], list[int]] = {}
        for run in sorted(set().union(*first_runs)):
            present = [first[run] for first in first_runs if run in first]
            sets.setdefault(tuple(first.get(run, present[0]) for first in first_runs), []).append(run)
        kind = "Runs" if "single" in protocols else f"{protocols[0].capitalize()} runs"
        equal = (", ".join(map(str, runs)) for runs in sets.values() if len(runs) > 1)
        notes += [f"{kind} {runs} are identical in every episode and count as one." for runs in equal]
        distinct = {runs[0] for runs in sets.values()}
        logs |= {name: select_runs(logs[name], distinct) for name in protocols if name in logs}
    paired = [set(logs[name].runs) for name in PAIRED_PROTOCOLS[0] if name in logs]
    if both := sorted(set.intersection(*paired)) if len(paired) > 1 and paired[0] != paired[1] else []:
        runs = ", ".join(map(str, both))
        notes.append(f"Metrics of transfer are over the runs that sequential and single both have: {runs}.")
    return replace(submitted, logs=logs, notes=tuple(notes))


def select_runs(log: Log, runs: set[int]) -> Log:
    """The rows of a log that belong to these runs."""
    return replace(log, rows=log.rows[log.rows["run"].isin(runs)].reset_index(drop=True))


def first_identical_runs(log: Log) -> Mapping[int, int]:
    """For each run, the first run that is identical in every episode.

    That is the run itself if it is the first. Returns that differ by less than ``TOLERANCE`` are identical.
    """
    ordered = log.rows.sort_values(["run", "stage", "position", "episode"], kind="stable")
    names = ["stage", "position", "episode", "length", "terminated", "success"]
    firsts: dict[bytes, list[tuple[int, NDArray[np.float64]]]] = {}
    result = {}
    for run in log.runs:
        rows = ordered[ordered["run"] == run]
        candidates = firsts.setdefault(b"".join(rows[name].to_numpy().tobytes() for name in names), [])
        returns = rows["return"].to_numpy()
        equal = (each for each, other in candidates if np.allclose(returns, other, TOLERANCE, TOLERANCE))
        result[run] = next(equal, run)
        if result[run] == run:
            candidates.append((run, returns))
    return result
