"""Verifies a submission: repeats logged episodes with the stored policies, and runs these on new seeds."""

import contextlib
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cached_property
from statistics import fmean
from typing import Any, NamedTuple

import numpy as np

from gym_extensions.catalog.protocol import EVALUATION_EPISODES, IN_ORDER, evaluation_seed
from gym_extensions.envs import fingerprinting, rollout
from gym_extensions.errors import BenchError
from gym_extensions.submissions import fetch, layout, problem, review
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.policies import files, onnx
from gym_extensions.submissions.run import ARITHMETIC, RunDocument, read_run
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification import episodes as episodess, limits, new_seeds
from gym_extensions.versions import processor, version

UNDECIDED = "undecided: too slow, with {:g} hours of processor time in all and {} s a cell; publish smaller "
UNDECIDED += "policies or fewer runs at once, or ask a maintainer for more time (verify --hours N --write)"


def logged_cells(log: Log, run: int) -> dict[tuple[int, int], list[rollout.Outcome]]:
    """The logged outcomes of a run by stage and index of the task, sorted as in the log."""
    cells = defaultdict[tuple[int, int], list[rollout.Outcome]](list)
    rows = log.rows[log.rows["run"] == run]
    names = ("stage", "position", "length", "return", "terminated", "success")
    columns = (rows[name].tolist() for name in names)
    for stage, position, length, return_, terminated, success in zip(*columns, strict=True):
        outcome = rollout.Outcome(length, return_, terminated, None if success < 0 else bool(success))
        cells[stage, position].append(outcome)
    return dict(cells)


@dataclass(frozen=True)
class LoggedRun:
    """A run of a submission: the log of its group and protocol, with all runs, and its document."""

    log: Log
    document: RunDocument

    @property
    def name(self) -> str:
        """Its name in review.toml, ``group/protocol/runN``."""
        return layout.run_key(self.log.group.name, self.log.protocol, self.document.run)

    @cached_property
    def logged(self) -> dict[tuple[int, int], list[rollout.Outcome]]:
        """The logged outcomes by stage and index of the task."""
        return logged_cells(self.log, self.document.run)

    @property
    def prescribed(self) -> tuple[episodess.Cell, ...]:
        """All cells of the log, with the prescribed seeds."""
        return tuple(self.prescribed_cell(*key) for key in self.logged)

    def prescribed_cell(self, stage: int, task: int) -> episodess.Cell:
        """A cell with the prescribed seeds."""
        names, episodes = (self.log.group.id, self.log.group.task_ids[task]), range(EVALUATION_EPISODES)
        return episodess.Cell(stage, task, tuple(evaluation_seed(*names, episode) for episode in episodes))

    def tested(self, draw: new_seeds.Draw) -> tuple[episodess.Cell, ...]:
        """All cells of the log, because metrics use them all, with the new seeds of a draw."""
        group, cells = self.log.group, []
        for stage, task in self.logged:
            task_id = group.task_ids[task]
            noise = draw.seed(group.id, self.log.protocol, self.document.run, stage, task_id)
            cells.append(episodess.Cell(stage, task, tuple(draw.seeds(group.id, task_id)), noise))
        return tuple(cells)

    def request(
        self,
        submission: Submission,
        cells: tuple[episodess.Cell, ...] = (),
        fetcher: fetch.Fetcher | None = None,
    ) -> episodess.RunRequest:
        """The request for cells of the run, whose policies are in the folder of the submission or fetched."""
        document, policies, manifest = self.document, self.document.policies, submission.manifest
        assert policies is not None
        assert manifest is not None, "it has no problems"
        return episodess.RunRequest(
            folder=str(submission.path.resolve()),
            group=self.log.group.name,
            protocol=document.protocol,
            run=document.run,
            policies=policies.sha256,
            observes_task=manifest.observes.task_in_evaluation,
            cells=cells,
            file=str(fetcher.fetch(policies, self.name)) if fetcher and policies.url else "",
        )

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
        text = differing({name: pair for name, pair in pairs.items() if pair[0]})
        return text and f"Made elsewhere (run / here): {text}."


def differing(pairs: Mapping[str, tuple[object, object]]) -> str:
    """The pairs (there, here) that are not equal, in words."""
    unequal = ((name, stated, now) for name, (stated, now) in pairs.items() if stated != now)
    return ", ".join(f"{name} {stated or 'unknown'} / {now}" for name, stated, now in unequal)


class Repetition(NamedTuple):
    """How many of a run's episodes were repeated, and where the first other one is and how large it is.

    ``machine`` says why honest ones may differ here (:meth:`LoggedRun.other_machine`).
    """

    repeated: int
    episodes: int
    difference: str = ""
    machine: str = ""


def repetition(run: LoggedRun, cells: Sequence[episodess.Cell], result: episodess.Played) -> Repetition:
    """Compares the outcomes of cells of a run with its log.

    They must be equal to the last bit; those of an ONNX network, the returns within ``review.TOLERANCE``.
    """
    total = sum(len(run.logged[cell.stage, cell.task]) for cell in cells)
    machine = run.other_machine(result.runtime)
    if result.problem:
        return Repetition(0, total, result.problem, machine)
    tolerance = review.TOLERANCE if result.runtime else 0.0
    repeated, difference = 0, ""
    for cell, outcomes in zip(cells, result.outcomes, strict=True):
        logged = run.logged[cell.stage, cell.task]
        for episode, (old, new) in enumerate(zip(logged, outcomes, strict=True)):
            distance = abs(old.return_ - new.return_)
            is_near = distance <= tolerance * max(1.0, abs(old.return_))
            if is_near and old._replace(return_=new.return_) == new:
                repeated += 1
            elif not difference:
                where = f"stage {cell.stage}, {run.log.group.tasks[cell.task].name}, episode {episode}"
                difference = f"{where}: {_described(old)} in the log, {_described(new)} here"
                difference += f" (difference {new.return_ - old.return_:.3g})"
    return Repetition(repeated, total, difference, machine)


def _described(outcome: rollout.Outcome) -> str:
    success = "" if outcome.success is None else f", success {str(outcome.success).lower()}"
    end = "terminated" if outcome.terminated else "truncated"
    return f"return {outcome.return_!r}, {end} after {outcome.length} steps{success}"


@dataclass(frozen=True)
class Report:
    """What a verification found. With problems, nothing was run.

    Args:
        verification: the record; None with problems, or without a run that can be verified.
        runs: how each run was repeated, by name; none of policies that sample, or of the first arithmetic.
        means: the mean returns in each log and on new seeds, in words, by ``group/protocol``.
        without_policies: names of the runs that publish none.
        twins: which run has nearly the policies of another one, in words; empty if none has.
        first_arithmetic: names of the runs whose episodes were logged in it.
        retraining: how a run that was trained again compares; empty if none was.
    """

    name: str
    problems: tuple[problem.Problem, ...] = ()
    verification: review.Verification | None = None
    runs: Mapping[str, Repetition] = field(default_factory=dict)
    means: Mapping[str, str] = field(default_factory=dict)
    without_policies: tuple[str, ...] = ()
    twins: str = ""
    first_arithmetic: tuple[str, ...] = ()
    retraining: str = ""


def logged_runs(submission: Submission) -> dict[str, LoggedRun]:
    """The runs of a submission by name, group by group."""
    runs = (
        LoggedRun(group.logs[protocol], document)
        for group in submission.groups.values()
        for protocol, documents in group.runs.items()
        for document in documents.values()
        if protocol in group.logs
    )
    return {run.name: run for run in runs}


def is_first_arithmetic(submission: Submission, run: LoggedRun) -> bool:
    """Whether the episodes of a run are repeated only by the arithmetic of the machine that logged them."""
    return run.document.arithmetic != ARITHMETIC and not submission.is_sampled


def settings_of(submission: Submission) -> str:
    """The digest of what the manifest of a submission without problems says of the agent."""
    assert submission.manifest is not None, "it has no problems"
    return submission.manifest.digest


def verify(
    submission: Submission,
    value: str,
    player: episodess.Player,
    fetcher: fetch.Fetcher,
    only: Collection[str] | None = None,
    *,
    is_trial: bool = False,
) -> Report:
    """Verifies the runs of a submission that have policies.

    Args:
        submission: the submission.
        value: 40 to 128 hexadecimal digits that were fixed after the files.
        player: runs the policies. Those that need more than its hours are *undecided: too slow*.
        fetcher: gets policies that lie elsewhere.
        only: the names of the runs to verify; all if None.
        is_trial: whether nothing is stored. Then runs of the first arithmetic are tried on new seeds, too;
            they are not repeated.

    Raises:
        BenchError: policies that lie elsewhere cannot be fetched, a limit was reached, or another version of
            MuJoCo or Gymnasium is installed. Nothing is decided then.
    """
    if submission.problems:
        return Report(submission.name, submission.problems)
    runs = logged_runs(submission)
    without = tuple(name for name, run in runs.items() if run.document.policies is None)
    chosen = (set(runs) if only is None else set(only)).difference(without)
    old = tuple(name for name in runs if name in chosen and is_first_arithmetic(submission, runs[name]))
    report, every = Report(submission.name, without_policies=without, first_arithmetic=old), runs
    chosen = chosen.difference(() if is_trial else old)
    runs = {name: run for name, run in runs.items() if name in chosen}
    if not runs:
        return report
    requests = {name: run.request(submission, fetcher=fetcher) for name, run in runs.items()}

    def play(cells: Mapping[str, tuple[episodess.Cell, ...]]) -> dict[str, episodess.Played]:
        wanted = [replace(request, cells=cells[name]) for name, request in requests.items()]
        return dict(zip(requests, player.play(wanted), strict=True))

    digests = {name: run.document.digest for name, run in runs.items()}
    contents = {name: run.document.files for name, run in runs.items()}
    draw = new_seeds.Draw(new_seeds.files_digest(contents), value)
    repeatable = [] if submission.is_sampled else [name for name in runs if name not in old]
    prescribed = {name: run.prescribed if name in repeatable else () for name, run in runs.items()}
    facts: dict[str, Any] = {
        "date": datetime.now(UTC).date().isoformat(),
        "version": version("gym-extensions"),
        "value": value,
        "settings": settings_of(submission),
        "runs": digests,
        "files": contents,
    }
    others, second = runs_to_compare(submission, every, runs), replace(draw, number=2)
    try:
        first = play({name: (*prescribed[name], *run.tested(draw)) for name, run in runs.items()})
        compared = player.play(list(others.values()))
        fresh = {name: each.outcomes[len(prescribed[name]) :] for name, each in first.items()}
        failed = _failure(first)
        repetitions = {}
        for name in repeatable:
            result = replace(first[name], outcomes=first[name].outcomes[: len(prescribed[name])])
            repetitions[name] = repetition(runs[name], prescribed[name], result)
        differences = [(name, each) for name, each in repetitions.items() if each.difference]
        here = [f"{name}: {each.difference}" for name, each in differences if not each.machine]
        sketches = {name: each.sketches for name, each in first.items()}
        sketches |= {name: each.sketches for name, each in zip(others, compared, strict=True)}
        twins = _twins(runs, sketches)
        p_values = [0.0] if failed else [_p_value(runs, draw, fresh)]
        if not (failed or here or twins or new_seeds.agrees(p_values[0])):
            again = play({name: run.tested(second) for name, run in runs.items()})
            outcomes, failed = {name: each.outcomes for name, each in again.items()}, _failure(again)
            p_values.append(0.0 if failed else _p_value(runs, second, outcomes))
    except BenchError as error:
        if error.code != limits.TOO_SLOW:
            raise
        why = UNDECIDED.format(player.hours, episodess.SECONDS_PER_CELL)
        found = review.Verification(**facts, cells=0, p_value=1.0, passed=False, undecided=why)
        return replace(report, verification=found)
    elsewhere = [f"{name}: {each.difference} [{each.machine}]" for name, each in differences if each.machine]
    return replace(
        report,
        verification=review.Verification(
            **facts,
            episodes=sum(each.episodes for each in repetitions.values()),
            repeated=sum(each.repeated for each in repetitions.values()),
            difference=next(filter(None, (failed, twins, *here, *elsewhere)), ""),  # what decides is first
            runtime=next((each.runtime for each in first.values() if each.runtime), ""),
            cells=sum(map(len, fresh.values())),
            p_value=p_values[0],
            second_p_value=p_values[1] if len(p_values) > 1 else None,
            passed=new_seeds.agrees(p_values[-1]) and not here and not twins,
        ),
        runs=repetitions,
        twins=twins,
        means={} if failed else _means(runs, fresh),
    )


def _failure(found: Mapping[str, episodess.Played]) -> str:
    """Why the policies of a run do not play, with its name; empty if all do."""
    return next((f"{name}: {each.problem}" for name, each in found.items() if each.problem), "")


def runs_to_compare(
    submission: Submission, every: Mapping[str, LoggedRun], runs: Collection[str]
) -> dict[str, episodess.RunRequest]:
    """Requests for the policies with which those of ``runs`` are compared, by name, without cells.

    They are of the other runs of the same logs, and of the runs of submissions beside this one that were
    verified or trained here, on the same tasks in order, ``submission/group/protocol/runN``. What cannot be
    read is left out.
    """
    logs, here = {every[name].log.path for name in runs}, submission.path.resolve()
    found = {
        name: run.request(submission)
        for name, run in every.items()
        if name not in runs and run.log.path in logs
        if run.document.policies is not None and not run.document.policies.url
    }
    written = (here.parent.glob(f"*/{name}") for name in (layout.REVIEW, f"{layout.TRAINED}/*.toml"))
    for path in sorted(path for paths in written for path in paths if here not in path.parents):
        folder, passed = path.parent, dict[str, str]()
        with contextlib.suppress(BenchError, OSError, ValueError):
            if path.name != layout.REVIEW:
                folder, passed = path.with_suffix(""), review.training_of(path.read_bytes()).runs
            for part in review.read_review(folder).verifications:
                passed |= part.runs if part.passed else {}
        for name, digest in passed.items():
            log, _, _ = name.rpartition("/")
            group, _, protocol = log.partition("/")
            if log not in logs or protocol not in IN_ORDER:
                continue
            with contextlib.suppress(BenchError):
                document = read_run(folder / f"{name}{layout.DOCUMENT}")
                if document.digest == digest and document.policies and not document.policies.url:
                    numbers = protocol, document.run, document.policies.sha256
                    found[f"{folder.relative_to(here.parent).as_posix()}/{name}"] = episodess.RunRequest(
                        str(folder), group, *numbers, True, ()
                    )
    return found


def _twins(runs: Mapping[str, LoggedRun], sketches: Mapping[str, files.Sketches]) -> str:
    """Which run has nearly the policies of another one, so that they are one run; empty if none has.

    Of other submissions only the last policy counts: methods with a common parent share the first.
    """
    for name, run in runs.items():
        last = f"stage{len(run.log.group.tasks)}"
        own = {place: sketch for place, sketch in sketches[name].items() if place == last}
        for other, theirs in sketches.items():
            where = ""
            if other != name and other.startswith(f"{run.log.path}/"):
                where = files.nearly_equal(sketches[name], theirs)
            elif f"/{run.log.path}/" in other:
                where = files.nearly_equal(own, theirs, files.COPIED_POLICY)
            if where:
                return f"{name}: nearly the same policy as {other}, {where}"
    return ""


Fresh = Mapping[str, Sequence[Sequence[rollout.Outcome]]]
"""The outcomes of the tested cells on new seeds by the name of the run."""


def _p_value(runs: Mapping[str, LoggedRun], draw: new_seeds.Draw, fresh: Fresh) -> float:
    """That of the logged returns of the tested cells against those on new seeds, task by task."""
    parts = defaultdict[tuple[str, int], list[tuple[int, int, list[float], list[float]]]](list)
    for index, (name, run) in enumerate(runs.items()):
        for cell, outcomes in zip(run.tested(draw), fresh[name], strict=True):
            old = [outcome.return_ for outcome in run.logged[cell.stage, cell.task]]
            new = [outcome.return_ for outcome in outcomes]
            parts[run.log.group.id, cell.task].append((index, cell.stage, old, new))
    columns = (zip(*cells, strict=True) for cells in parts.values())
    tasks = [
        new_seeds.TaskReturns(indices, stages, np.array(old), np.array(new))
        for indices, stages, old, new in columns
    ]
    return new_seeds.compare(tasks, np.random.default_rng(draw.seed("permutations")))


def _means(runs: Mapping[str, LoggedRun], fresh: Fresh) -> dict[str, str]:
    """The means of the tested cells, in words, by ``group/protocol``."""
    cells = defaultdict[str, tuple[list[Any], list[Any]]](lambda: ([], []))
    for name, run in runs.items():
        logged, new = cells[run.log.path]
        logged += run.logged.values()
        new += fresh[name]
    found = {}
    for log, both in cells.items():
        old, now = (fmean(outcome.return_ for cell in part for outcome in cell) for part in both)
        found[log] = f"mean return {old:.1f} in the log, {now:.1f} on new seeds ({len(both[0])} cells)"
    return found
