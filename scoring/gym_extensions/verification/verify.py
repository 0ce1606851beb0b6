"""Verifies an entry: repeats its logged episodes with the stored policies, and runs these on new seeds."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from statistics import fmean

import msgspec
import numpy as np

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.review import Review, Verification, read_review, write_review
from gym_extensions.rollouts.run import RunDocument
from gym_extensions.rollouts.submission import Submission
from gym_extensions.rollouts.tables import Log
from gym_extensions.verification.episodes import Cell, Played, RunRequest, Store, run_all
from gym_extensions.verification.fetch import Fetcher
from gym_extensions.verification.new_seeds import Draw, TaskReturns, compare, files_digest, tested_cells
from gym_extensions.verification.repeat import (
    Repetition,
    logged_cells,
    other_machine,
    prescribed_cell,
    repetition,
    this_machine,
)
from gym_extensions.versions import blas_kernels, version

SAMPLED = "sampled"


@dataclass(frozen=True)
class Run:
    """A run of an entry: its name ``group/protocol/runN``, its logs, its number and its document."""

    name: str
    log: Log
    number: int
    document: RunDocument

    @property
    def prescribed(self) -> tuple[Cell, ...]:
        """All cells of the log, with the prescribed seeds."""
        return tuple(prescribed_cell(self.log, *key) for key in logged_cells(self.log, self.number))

    def tested(self, draw: Draw) -> tuple[Cell, ...]:
        """The cells of final performance and forgetting, with the new seeds of a draw."""
        group = self.log.group
        cells = []
        for stage, task in tested_cells(self.log.protocol, group.tasks):
            task_id = group.task_ids[task]
            noise = draw.seed(group.id, self.log.protocol, self.number, stage, task_id)
            cells.append(Cell(stage, task, tuple(draw.seeds(group.id, task_id)), noise))
        return tuple(cells)


@dataclass(frozen=True)
class Means:
    """The mean return of a log's tested cells, as logged and on new seeds, and their number."""

    logged: float
    fresh: float
    cells: int


@dataclass(frozen=True)
class Report:
    """What a verification found.

    Args:
        name: of the entry.
        problems: broken rules; then nothing was run.
        verification: the record; None with problems, or without a run that can be verified.
        runs: how each run was repeated, by name; empty if the policies sample their actions.
        machines: what differs between the machine of each run and this one, by name; empty where nothing.
        means: by group and protocol, ``group/protocol``.
        without_policies: the runs that publish no policies, by name.
        retraining: how a run that was trained again compares; empty if none was.
    """

    name: str
    problems: tuple[Problem, ...] = ()
    verification: Verification | None = None
    runs: Mapping[str, Repetition] = field(default_factory=dict)
    machines: Mapping[str, str] = field(default_factory=dict)
    means: Mapping[str, Means] = field(default_factory=dict)
    without_policies: tuple[str, ...] = ()
    retraining: str = ""


def runs_of(submission: Submission) -> dict[str, Run]:
    """The runs of an entry by name, group by group."""
    return {
        f"{group.group.name}/{protocol}/run{number}": Run(
            f"{group.group.name}/{protocol}/run{number}", group.logs[protocol], number, document
        )
        for group in submission.groups.values()
        for protocol, documents in group.runs.items()
        for number, document in sorted(documents.items())
        if protocol in group.logs
    }


def verified_before(review: Review, runs: Mapping[str, Run]) -> dict[str, Verification]:
    """The verification that decided about each run with the files that it has now, by the run's name."""
    decided: dict[str, Verification] = {}
    for verification in review.verifications:
        for name, digest in verification.runs.items():
            if name in runs and runs[name].document.digest == digest:
                decided.setdefault(name, verification)
    return decided


def record(entry: Path, verification: Verification) -> None:
    """Adds a verification to the review of an entry, whole or not at all."""
    review = read_review(entry)
    verifications = [*review.verifications, verification]
    write_review(entry, msgspec.structs.replace(review, verifications=verifications))


def request_of_run(
    run: Run, folder: Path, observes_task: bool, cells: tuple[Cell, ...] = (), file: str = ""
) -> RunRequest:
    """The request for cells of a run, whose policies are in the entry's folder, or in a file elsewhere."""
    assert run.document.policies is not None
    group, protocol, digest = run.log.group.name, run.log.protocol, run.document.policies.sha256
    files = run.document.digest
    return RunRequest(
        run.name, str(folder), group, protocol, run.number, digest, files, observes_task, cells, file
    )


class Verifier:
    """Verifies the runs of one entry.

    Args:
        path: the entry's folder.
        value: 40 to 128 hexadecimal digits that were fixed after the files.
        store: keeps outcomes, so that an interrupted verification goes on where it was.
        fetcher: gets policies that lie elsewhere.
        groups: the groups that the entry may contain, by name.
        files: TOML files of custom groups among them.
        jobs: processes that work at once.
        started: called with the number of cells before they are run.
        done: called with the number of cells of each finished run, in any thread.
    """

    def __init__(
        self,
        path: Path,
        value: str,
        store: Store,
        fetcher: Fetcher,
        *,
        groups: Mapping[str, TaskGroup] = GROUPS,
        files: Sequence[str] = (),
        jobs: int = 1,
        started: Callable[[int], None] = lambda _: None,
        done: Callable[[int], None] = lambda _: None,
    ) -> None:
        self._path, self._value, self._store, self._fetcher = path.resolve(), value, store, fetcher
        self._groups, self._files, self._jobs = groups, files, jobs
        self._started, self._done = started, done

    def verify(self, *, only_new: bool = False) -> Report:
        """Verifies all runs with policies, or only those about which no verification has decided.

        Raises:
            BenchError: policies that lie elsewhere cannot be fetched, a limit was reached, or another version
                of MuJoCo or Gymnasium is installed. Nothing is decided then.
        """
        submission = read(self._path, self._groups, merge_runs=False)
        if submission.problems:
            return Report(submission.name, submission.problems)
        runs = runs_of(submission)
        without = tuple(name for name, run in runs.items() if run.document.policies is None)
        decided = verified_before(submission.review, runs) if only_new else {}
        runs = {name: run for name, run in runs.items() if name not in decided and name not in without}
        if not runs:
            return Report(submission.name, without_policies=without)
        manifest = submission.manifest
        assert manifest is not None, "it has no problems"
        is_repeatable = manifest.protocol.evaluation != SAMPLED
        digests = {name: run.document.digest for name, run in runs.items()}
        draw = Draw(files_digest(digests), self._value)
        files = {name: self._file(run) for name, run in runs.items()}
        observes_task = manifest.observes.task_in_evaluation
        requests = [
            request_of_run(run, self._path, observes_task, file=files[name]) for name, run in runs.items()
        ]
        repeated = {name: run.prescribed if is_repeatable else () for name, run in runs.items()}
        first = self._play(
            requests, {name: (*repeated[name], *run.tested(draw)) for name, run in runs.items()}
        )
        split = {name: len(cells) for name, cells in repeated.items()}
        old = {name: replace(each, outcomes=each.outcomes[: split[name]]) for name, each in first.items()}
        new = {name: replace(each, outcomes=each.outcomes[split[name] :]) for name, each in first.items()}
        repetitions = {
            name: repetition(run.log, run.number, repeated[name], old[name])
            for name, run in runs.items()
            if is_repeatable
        }
        here = this_machine()
        made = {name: run.document for name, run in runs.items()}
        machines = {name: other_machine(each.versions, here, each.packages) for name, each in made.items()}
        failed = next((f"{name}: {each.problem}" for name, each in first.items() if each.problem), "")
        p_values, agrees = ([0.0], False) if failed else self._test(runs, requests, draw, new)
        is_other = any(each.difference and not machines[name] for name, each in repetitions.items())
        return Report(
            name=submission.name,
            verification=Verification(
                date=datetime.now(UTC).date().isoformat(),
                version=version("gym-extensions"),
                value=self._value,
                runs=digests,
                episodes=sum(int((run.log.run == run.number).sum()) for run in runs.values()),
                repeated=sum(each.repeated for each in repetitions.values()),
                difference=failed or _first_difference(repetitions, machines),
                kernels=blas_kernels(),
                runtime=next((each.runtime for each in first.values() if each.runtime), ""),
                cells=sum(len(each.outcomes) for each in new.values()),
                p_value=p_values[0],
                second_p_value=p_values[1] if len(p_values) > 1 else None,
                passed=agrees and not is_other,
            ),
            runs=repetitions,
            machines={name: text for name, text in machines.items() if text},
            means={} if failed else means(runs, draw, new),
            without_policies=without,
        )

    def _test(
        self,
        runs: Mapping[str, Run],
        requests: Sequence[RunRequest],
        draw: Draw,
        played: Mapping[str, Played],
    ) -> tuple[list[float], bool]:
        """The p value of the first draw, that of a second if the first refuses, and whether one agrees."""
        p_values: list[float] = []
        for number in (1, 2):
            if number == 2:
                draw = Draw(draw.digest, draw.value, number)
                played = self._play(requests, {name: run.tested(draw) for name, run in runs.items()})
            test = compare(task_returns(runs, draw, played), np.random.default_rng(draw.seed("permutations")))
            p_values.append(test.p_value)
            if test.agrees:
                return p_values, True
        return p_values, False

    def _file(self, run: Run) -> str:
        policies = run.document.policies
        return str(self._fetcher.fetch(policies, run.name)) if policies and policies.url else ""

    def _play(
        self, requests: Sequence[RunRequest], cells: Mapping[str, tuple[Cell, ...]]
    ) -> dict[str, Played]:
        wanted = [replace(request, cells=cells[request.name]) for request in requests]
        self._started(sum(len(request.cells) for request in wanted))
        results = run_all(
            wanted,
            self._store,
            groups=self._files,
            jobs=self._jobs,
            done=lambda request: self._done(len(request.cells)),
        )
        return {request.name: results[request.name] for request in requests}


def _first_difference(repetitions: Mapping[str, Repetition], machines: Mapping[str, str]) -> str:
    """Where the first repeated episode differs; empty if none does.

    Runs of this kind of machine come first, because a difference there decides.
    """
    for name in sorted(repetitions, key=lambda name: bool(machines[name])):
        if difference := repetitions[name].difference:
            return f"{name}: {difference}" + (f" [other machine: {machines[name]}]" if machines[name] else "")
    return ""


def task_returns(runs: Mapping[str, Run], draw: Draw, results: Mapping[str, Played]) -> list[TaskReturns]:
    """The logged returns of the tested cells and those on new seeds, by task."""
    parts: dict[tuple[str, int], list[tuple[int, list[float], list[float]]]] = defaultdict(list)
    for index, (name, run) in enumerate(runs.items()):
        logged = logged_cells(run.log, run.number)
        for cell, outcomes in zip(run.tested(draw), results[name].outcomes, strict=True):
            old = [outcome.return_ for outcome in logged[cell.stage, cell.task]]
            new = [outcome.return_ for outcome in outcomes]
            parts[run.log.group.id, cell.task].append((index, old, new))
    return [
        TaskReturns([part[0] for part in cells], *(np.array([part[at] for part in cells]) for at in (1, 2)))
        for cells in parts.values()
    ]


def means(runs: Mapping[str, Run], draw: Draw, results: Mapping[str, Played]) -> dict[str, Means]:
    """The means of the tested cells by ``group/protocol``."""
    names = {name: name.rpartition("/")[0] for name in runs}
    found = {}
    for log in dict.fromkeys(names.values()):
        part = {name: run for name, run in runs.items() if names[name] == log}
        tasks = task_returns(part, draw, results)
        old, new = (np.concatenate([getattr(task, kind) for task in tasks]) for kind in ("logged", "fresh"))
        found[log] = Means(fmean(old.ravel().tolist()), fmean(new.ravel().tolist()), len(old))
    return found
