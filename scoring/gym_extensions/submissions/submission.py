"""A submission that has been read, and the runs of it that are scored."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.submissions import layout, problem
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.manifest import Manifest
from gym_extensions.submissions.review import Review, Training
from gym_extensions.submissions.run import Memory, RunDocument, consecutive


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
    empty without one; ``review`` is what the base branch found out
    (:func:`gym_extensions.submissions.review.about`); ``path`` is the folder that was read; ``code`` is the
    digest of its code, empty without any, and ``trained`` what the base trained of it.
    """

    name: str
    manifest: Manifest | None
    groups: dict[str, SubmittedGroup]
    problems: tuple[problem.Problem, ...] = ()
    readme: str = ""
    review: Review = field(default_factory=Review)
    path: Path = Path()
    code: str = ""
    trained: "Trained | None" = None

    def __repr__(self) -> str:
        return f"Submission({self.name!r}, groups={list(self.groups)}, {len(self.problems)} problems)"

    @property
    def shown_groups(self) -> dict[str, SubmittedGroup]:
        """The groups by id. Where the author has no runs of a protocol, those that were trained here."""
        groups = dict(self.groups)
        for id_, made in (self.trained.runs.groups if self.trained else {}).items():
            own = groups.get(id_, made)
            groups[id_] = replace(own, logs=made.logs | own.logs, runs=made.runs | own.runs)
        return groups

    @property
    def documents(self) -> dict[str, RunDocument]:
        """The documents of all runs by the run's name, ``group/protocol/runN``."""
        return {
            layout.run_key(group.group.name, protocol, run): document
            for group in self.groups.values()
            for protocol, documents in group.runs.items()
            for run, document in documents.items()
        }

    @property
    def memory(self) -> Memory | None:
        """The largest memory of all runs; None without runs."""
        parts = [msgspec.structs.astuple(document.memory) for document in self.documents.values()]
        largest = map(max, zip(*parts, strict=True))
        return Memory(**dict(zip(Memory.__struct_fields__, largest, strict=True))) if parts else None


@dataclass(frozen=True)
class Trained:
    """What the base branch trained: the number of the version of the code, the record, and the runs."""

    version: int
    training: Training
    runs: Submission


def scored_group(submitted: SubmittedGroup) -> SubmittedGroup:
    """The group with the runs that are scored: 0 to N − 1 of each log, up to the first gap. Notes say so."""
    logs, notes = dict(submitted.logs), list[str]()
    for protocol, log in submitted.logs.items():
        count = consecutive(log.runs)
        if later := [run for run in log.runs if run > count]:
            logs[protocol] = replace(log, rows=log.rows[log.rows["run"] < count].reset_index(drop=True))
            runs = ", ".join(map(str, later))
            notes.append(f"{protocol}: run {count} is missing; until it is there, not scored: {runs}.")
    paired = [set(logs[name].runs) for name in ("sequential", "single") if name in logs]
    if both := sorted(set.intersection(*paired)) if len(paired) > 1 and paired[0] != paired[1] else []:
        runs = ", ".join(map(str, both))
        notes.append(f"Metrics of transfer are over the runs that sequential and single both have: {runs}.")
    return replace(submitted, logs=logs, notes=tuple(notes))
