"""A run of a submission with its log: the cells that are played again, and whether they repeat the log."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.envs import fingerprinting, rollout
from gym_extensions.submissions import fetch, layout, review
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.policies import onnx
from gym_extensions.submissions.run import ARITHMETIC, RunDocument
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification.episodes import Cell, Played, RunRequest
from gym_extensions.verification.new_seeds import Draw
from gym_extensions.versions import processor


@dataclass(frozen=True)
class LoggedRun:
    """A run of a submission: the log of its group and protocol, with all runs, and its document."""

    submission: Submission
    log: Log
    document: RunDocument

    @property
    def name(self) -> str:
        """Its name in review.toml, ``group/protocol/runN``."""
        return layout.run_key(self.log.group.name, self.log.protocol, self.document.run)

    @cached_property
    def logged(self) -> dict[tuple[int, int], list[rollout.Outcome]]:
        """The logged outcomes by stage and index of the task, sorted as in the log."""
        cells = defaultdict[tuple[int, int], list[rollout.Outcome]](list)
        rows = self.log.rows[self.log.rows["run"] == self.document.run]
        for row in rows.to_dict("records"):
            success = None if row["success"] < 0 else bool(row["success"])
            outcome = rollout.Outcome(row["length"], row["return"], row["terminated"], success)
            cells[row["stage"], row["position"]].append(outcome)
        return dict(cells)

    @property
    def prescribed_cells(self) -> tuple[Cell, ...]:
        """All cells of the log, with the prescribed seeds."""
        return tuple(self.prescribed_cell(*key) for key in self.logged)

    def prescribed_cell(self, stage: int, task: int) -> Cell:
        """A cell with the prescribed seeds."""
        names, episodes = (self.log.group.id, self.log.group.task_ids[task]), range(EVALUATION_EPISODES)
        return Cell(stage, task, tuple(evaluation_seed(*names, episode) for episode in episodes))

    def new_cells(self, draw: Draw) -> tuple[Cell, ...]:
        """All cells of the log, because metrics use them all, with the new seeds of a draw."""
        group, cells = self.log.group, []
        for stage, task in self.logged:
            task_id = group.task_ids[task]
            noise = draw.seed(group.id, self.log.protocol, self.document.run, stage, task_id)
            cells.append(Cell(stage, task, tuple(draw.seeds(group.id, task_id)), noise))
        return tuple(cells)

    def request(self, cells: Sequence[Cell] = (), fetcher: fetch.Fetcher | None = None) -> RunRequest:
        """The request for cells of the run, whose policies are in the folder of the submission or fetched."""
        policies, manifest = self.document.policies, self.submission.manifest
        assert policies is not None
        assert manifest is not None, "it has no problems"
        return RunRequest(
            folder=str(self.submission.path.resolve()),
            group=self.log.group.name,
            protocol=self.log.protocol,
            run=self.document.run,
            policies=policies.sha256,
            observes_task=manifest.observes.task_in_evaluation,
            cells=tuple(cells),
            file=str(fetcher.fetch(policies, self.name)) if fetcher and policies.url else "",
        )

    @property
    def is_first_arithmetic(self) -> bool:
        """Whether its episodes are repeated only by the arithmetic of the machine that logged them."""
        return self.document.arithmetic != ARITHMETIC and not self.submission.is_sampled

    def other_machine(self, runtime: str) -> str:
        """Why honest episodes of the run may differ on this machine; empty if they may not.

        ``runtime`` is what ran its networks here. Without networks, what the document says does not matter:
        the engine is the published one everywhere, and plain policies have one arithmetic. Networks have
        other last bits on another system or processor, or with another version of the runtime, if the
        document states one.
        """
        why, document = fingerprinting.other_platform(), self.document
        if why or not runtime:
            return why
        pairs = {
            "platform": (document.versions.platform, fingerprinting.PLATFORM),
            "processor": (document.machine and document.machine.processor, processor()),
            onnx.RUNTIME: (document.packages.get(onnx.RUNTIME), runtime.rpartition(" ")[2]),
        }
        stated = differing({name: pair for name, pair in pairs.items() if pair[0]})
        return stated and f"Made elsewhere (run / here): {stated}."


def logged_runs(submission: Submission) -> dict[str, LoggedRun]:
    """The runs of a submission by name, group by group."""
    runs = (
        LoggedRun(submission, group.logs[protocol], document)
        for group in submission.groups.values()
        for protocol, documents in group.runs.items()
        for document in documents.values()
        if protocol in group.logs
    )
    return {run.name: run for run in runs}


def differing(pairs: Mapping[str, tuple[object, object]]) -> str:
    """The pairs (there, here) that are not equal, in words."""
    unequal = ((name, there, here) for name, (there, here) in pairs.items() if there != here)
    return ", ".join(f"{name} {there or 'unknown'} / {here}" for name, there, here in unequal)


class Repetition(NamedTuple):
    """How many of a run's episodes were repeated, and where the first other one is and how large it is.

    ``other_machine`` says why honest ones may differ here (:meth:`LoggedRun.other_machine`).
    """

    repeated: int
    episodes: int
    difference: str = ""
    other_machine: str = ""


def repetition(run: LoggedRun, cells: Sequence[Cell], played: Played) -> Repetition:
    """Compares cells of a run, whose outcomes are the first of what was played, with its log.

    They must be equal to the last bit; those of an ONNX network, the returns within ``review.TOLERANCE``.
    """
    episodes = sum(len(run.logged[cell.stage, cell.task]) for cell in cells)
    other_machine = run.other_machine(played.runtime)
    if played.problem:
        return Repetition(0, episodes, played.problem, other_machine)
    tolerance = review.TOLERANCE if played.runtime else 0.0
    repeated, difference = 0, ""
    for cell, outcomes in zip(cells, played.outcomes[: len(cells)], strict=True):
        logged = run.logged[cell.stage, cell.task]
        for episode, (old, new) in enumerate(zip(logged, outcomes, strict=True)):
            change = new.return_ - old.return_
            is_close = abs(change) <= tolerance * max(1.0, abs(old.return_))
            if is_close and old._replace(return_=new.return_) == new:
                repeated += 1
            elif not difference:
                where = f"stage {cell.stage}, {run.log.group.tasks[cell.task].name}, episode {episode}"
                difference = f"{where}: {_in_words(old)} in the log, {_in_words(new)} here"
                difference += f" (difference {change:.3g})"
    return Repetition(repeated, episodes, difference, other_machine)


def _in_words(outcome: rollout.Outcome) -> str:
    success = "" if outcome.success is None else f", success {str(outcome.success).lower()}"
    end = "terminated" if outcome.terminated else "truncated"
    return f"return {outcome.return_!r}, {end} after {outcome.length} steps{success}"
