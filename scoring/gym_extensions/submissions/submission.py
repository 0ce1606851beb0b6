"""A submission that has been read, and the runs of it that are scored."""

from dataclasses import dataclass, field, replace
from pathlib import Path

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.submissions import layout, problem
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.manifest import Manifest
from gym_extensions.submissions.review import Review, Training
from gym_extensions.submissions.run import Memory, RunDocument, consecutive


def runs_folder(submission: Path, group_name: str, protocol: str) -> Path:
    """The folder with the runs of a group and protocol: ``trained/N`` if some were trained here."""
    records = (f"{layout.TRAINED}/{path.name}" for path in submission.glob(f"{layout.TRAINED}/*.toml"))
    trained = submission / layout.TRAINED / str(layout.latest_version(records))
    return trained if (trained / group_name / protocol).is_dir() else submission


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
    def sources(self) -> "tuple[Submission, ...]":
        """The submission and what was trained of it here, each with those of its runs that count.

        A protocol of a group has one source (:func:`runs_folder`).
        """
        if self.trained is None:
            return (self,)
        trained, groups = self.trained.runs, {}
        for id_, each in self.groups.items():
            here = trained.groups[id_].runs if id_ in trained.groups else {}
            if runs := {name: part for name, part in each.runs.items() if name not in here}:
                logs = {name: log for name, log in each.logs.items() if name in runs}
                groups[id_] = replace(each, logs=logs, runs=runs)
        return replace(self, groups=groups), replace(trained, name=self.name)

    @property
    def shown_groups(self) -> dict[str, SubmittedGroup]:
        """The groups by id with the runs that count, wherever they lie."""
        groups: dict[str, SubmittedGroup] = {}
        for source in self.sources:
            for id_, each in source.groups.items():
                known = groups.get(id_, each)
                groups[id_] = replace(each, logs=each.logs | known.logs, runs=each.runs | known.runs)
        return groups

    @property
    def is_sampled(self) -> bool:
        """Whether the agent samples its actions in evaluation, so that no episode can be repeated."""
        return self.manifest is not None and self.manifest.protocol.evaluation == "sampled"

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
        parts = [document.memory for document in self.documents.values()]
        if not parts:
            return None
        largest = {name: max(getattr(each, name) for each in parts) for name in Memory.__struct_fields__}
        return Memory(**largest)


@dataclass(frozen=True)
class Trained:
    """What the base branch trained: the number of the version of the code, the record, and the runs."""

    version: int
    training: Training
    runs: Submission


def scored_group(submitted: SubmittedGroup) -> SubmittedGroup:
    """The group with the runs that are scored: 0 to N − 1 of each log, up to the first gap. Notes say so.

    A log without run 0 is left out.
    """
    logs, notes = dict(submitted.logs), list[str]()
    for protocol, log in submitted.logs.items():
        count = consecutive(log.runs)
        if later := [run for run in log.runs if run > count]:
            logs[protocol] = replace(log, rows=log.rows[log.rows["run"] < count].reset_index(drop=True))
            runs = ", ".join(map(str, later))
            notes.append(f"{protocol}: run {count} is missing; until it is there, not scored: {runs}.")
    logs = {protocol: log for protocol, log in logs.items() if log.runs}
    if "sequential" in logs and "single" in logs and logs["sequential"].runs != logs["single"].runs:
        both = range(min(len(logs["sequential"].runs), len(logs["single"].runs)))
        runs = ", ".join(map(str, both))
        notes.append(f"Metrics of transfer are over the runs that sequential and single both have: {runs}.")
    return replace(submitted, logs=logs, notes=tuple(notes))
