"""Verifies a submission: repeats logged episodes with the stored policies, and runs these on new seeds."""

import contextlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

from gym_extensions.catalog.protocol import IN_ORDER
from gym_extensions.envs.rollout import Outcome
from gym_extensions.errors import BenchError
from gym_extensions.submissions import fetch, layout, problem, review
from gym_extensions.submissions.policies import files
from gym_extensions.submissions.run import read_run
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification import limits, new_seeds
from gym_extensions.verification.episodes import SECONDS_PER_CELL, Cell, Played, Player, RunRequest
from gym_extensions.verification.logged_run import LoggedRun, Repetition, logged_runs, repetition
from gym_extensions.versions import version

UNDECIDED = "undecided: too slow, with {:g} hours of processor time in all and {} s a cell; publish smaller "
UNDECIDED += "policies or fewer runs at once, or ask a maintainer for more time (verify --hours N --write)"


@dataclass(frozen=True)
class Report:
    """What a verification found. With problems, nothing was run.

    Args:
        verification: the record; None with problems, or without a run that can be verified.
        repetitions: of each run by name; none of policies that sample, or of the first arithmetic.
        means: the mean returns in each log and on new seeds, in words, by ``group/protocol``.
        without_policies: names of the runs that publish none.
        twins: which run has nearly the policies of another one, in words; empty if none has.
        first_arithmetic: names of the runs whose episodes were logged in it.
        retraining: how a run that was trained again compares; empty if none was.
    """

    name: str
    problems: tuple[problem.Problem, ...] = ()
    verification: review.Verification | None = None
    repetitions: Mapping[str, Repetition] = field(default_factory=dict)
    means: Mapping[str, str] = field(default_factory=dict)
    without_policies: tuple[str, ...] = ()
    twins: str = ""
    first_arithmetic: tuple[str, ...] = ()
    retraining: str = ""


def settings_of(submission: Submission) -> str:
    """The digest of what the manifest of a submission without problems says of the agent."""
    assert submission.manifest is not None, "it has no problems"
    return submission.manifest.digest


def verify(
    submission: Submission,
    value: str,
    player: Player,
    fetcher: fetch.Fetcher,
    names: Collection[str] | None = None,
    *,
    is_trial: bool = False,
) -> Report:
    """Verifies the runs of a submission that have policies.

    Args:
        submission: without problems.
        value: 40 to 128 hexadecimal digits that were fixed after the files.
        player: runs the policies. Those that need more than its hours are *undecided: too slow*.
        fetcher: gets policies that lie elsewhere.
        names: of the runs to verify; all if None.
        is_trial: whether nothing is stored. Then runs of the first arithmetic are tried on new seeds, too;
            they are not repeated.

    Raises:
        BenchError: policies that lie elsewhere cannot be fetched, a limit was reached, or another version of
            MuJoCo or Gymnasium is installed. Nothing is decided then.
    """
    known = logged_runs(submission)
    without_policies = tuple(name for name, run in known.items() if run.document.policies is None)
    chosen = (name for name in known if names is None or name in names)
    runs = {name: known[name] for name in chosen if name not in without_policies}
    first_arithmetic = tuple(name for name, run in runs.items() if run.is_first_arithmetic)
    if not is_trial:
        runs = {name: run for name, run in runs.items() if name not in first_arithmetic}
    report = Report(submission.name)
    if runs:
        try:
            report = _findings(submission, value, runs, player, fetcher)
        except BenchError as error:
            if error.code != limits.TOO_SLOW:
                raise
            why = UNDECIDED.format(player.hours, SECONDS_PER_CELL)
            record = _record(submission, value, runs, cells=0, p_value=1.0, passed=False, undecided=why)
            report = replace(report, verification=record)
    return replace(report, without_policies=without_policies, first_arithmetic=first_arithmetic)


def _record(
    submission: Submission, value: str, runs: Mapping[str, LoggedRun], **found: Any
) -> review.Verification:
    """The record of what was found about runs."""
    return review.Verification(
        date=datetime.now(UTC).date().isoformat(),
        version=version("gym-extensions"),
        value=value,
        settings=settings_of(submission),
        runs={name: run.document.digest for name, run in runs.items()},
        files={name: run.document.files for name, run in runs.items()},
        **found,
    )


def _findings(
    submission: Submission,
    value: str,
    runs: Mapping[str, LoggedRun],
    player: Player,
    fetcher: fetch.Fetcher,
) -> Report:
    """The report on runs with policies.

    They are refuted by policies that fail, by an episode that differs though it must not, or by two runs that
    are one. If nothing of this has refuted them, and the test on new seeds is suspicious, a second draw
    decides.
    """
    requests = {name: run.request(fetcher=fetcher) for name, run in runs.items()}

    def play(cells: Mapping[str, Sequence[Cell]]) -> dict[str, Played]:
        wanted = [replace(request, cells=tuple(cells[name])) for name, request in requests.items()]
        return dict(zip(requests, player.play(wanted), strict=True))

    digest = new_seeds.files_digest({name: run.document.files for name, run in runs.items()})
    draw = new_seeds.Draw(digest, value)
    prescribed = {
        name: () if submission.is_sampled or run.is_first_arithmetic else run.prescribed_cells
        for name, run in runs.items()
    }
    first = play({name: (*prescribed[name], *run.new_cells(draw)) for name, run in runs.items()})

    failure = _failure(first)
    repetitions, refuting, excused = dict[str, Repetition](), list[str](), list[str]()
    for name, cells in prescribed.items():
        if cells:
            repetitions[name] = found = repetition(runs[name], cells, first[name])
            if found.difference and found.other_machine:
                excused.append(f"{name}: {found.difference} [{found.other_machine}]")
            elif found.difference:
                refuting.append(f"{name}: {found.difference}")
    twins = _twins(submission, runs, first, player)
    is_refuted = bool(failure or refuting or twins)

    p_value, second_p_value = _p_value(runs, draw, first), None
    if not is_refuted and not new_seeds.agrees(p_value):
        second_draw = replace(draw, number=2)
        second = play({name: run.new_cells(second_draw) for name, run in runs.items()})
        failure, second_p_value = _failure(second), _p_value(runs, second_draw, second)
    deciding_p_value = p_value if second_p_value is None else second_p_value

    record = _record(
        *(submission, value, runs),
        episodes=sum(each.episodes for each in repetitions.values()),
        repeated=sum(each.repeated for each in repetitions.values()),
        difference=next(filter(None, (failure, twins, *refuting, *excused)), ""),  # what decides is first
        runtime=next((played.runtime for played in first.values() if played.runtime), ""),
        cells=sum(len(run.logged) for name, run in runs.items() if not first[name].problem),
        p_value=p_value,
        second_p_value=second_p_value,
        passed=not is_refuted and new_seeds.agrees(deciding_p_value),
    )
    means = {} if failure else _means(runs, first)
    return Report(submission.name, verification=record, repetitions=repetitions, twins=twins, means=means)


def _failure(found: Mapping[str, Played]) -> str:
    """Why the policies of a run do not play, with its name; empty if all do."""
    return next((f"{name}: {played.problem}" for name, played in found.items() if played.problem), "")


def _twins(
    submission: Submission, runs: Mapping[str, LoggedRun], played: Mapping[str, Played], player: Player
) -> str:
    """Which run has nearly the policies of another one, so that they are one run; empty if none has.

    Of other submissions only the last policy counts: methods with a common parent share the first.
    """
    others = _other_runs(submission, runs)
    sketches = {name: each.sketches for name, each in played.items()}
    sketches |= {
        name: each.sketches for name, each in zip(others, player.play([*others.values()]), strict=True)
    }
    for name, run in runs.items():
        last = f"stage{len(run.log.group.tasks)}"
        last_policy = {place: sketch for place, sketch in sketches[name].items() if place == last}
        for other, theirs in sketches.items():
            where = ""
            if other != name and other.startswith(f"{run.log.path}/"):
                where = files.nearly_equal(sketches[name], theirs)
            elif f"/{run.log.path}/" in other:
                where = files.nearly_equal(last_policy, theirs, files.COPIED_POLICY)
            if where:
                return f"{name}: nearly the same policy as {other}, {where}"
    return ""


def _other_runs(submission: Submission, runs: Mapping[str, LoggedRun]) -> dict[str, RunRequest]:
    """Requests for the policies with which those of runs are compared, without cells.

    They are of the other runs of the same logs, by name, and of the runs on the same tasks in order that the
    submissions beside this one have, by ``submission/group/protocol/runN``. What cannot be read is left out.
    """
    logs, folder = {run.log.path for run in runs.values()}, submission.path.resolve()
    found = {
        name: run.request()
        for name, run in logged_runs(submission).items()
        if name not in runs and run.log.path in logs
        if run.document.policies is not None and not run.document.policies.url
    }
    beside = (each for each in sorted(folder.parent.glob("*")) if each != folder)
    for source, name, digest in (run for each in beside for run in _checked_runs(each)):
        group, protocol, _ = name.split("/")
        if f"{group}/{protocol}" not in logs or protocol not in IN_ORDER:
            continue
        with contextlib.suppress(BenchError):
            document = read_run(source / f"{name}{layout.DOCUMENT}")
            if document.digest == digest and document.policies and not document.policies.url:
                found[f"{source.relative_to(folder.parent).as_posix()}/{name}"] = RunRequest(
                    *(str(source), group, protocol, document.run, document.policies.sha256),
                    observes_task=True,  # here it does not matter whether it may
                    cells=(),
                )
    return found


def _checked_runs(submission: Path) -> Iterator[tuple[Path, str, str]]:
    """The runs of a submission that were verified or trained here: the folder, the name and the digest."""
    with contextlib.suppress(BenchError):
        for part in review.read_review(submission).verifications:
            if part.passed:
                yield from ((submission, *run) for run in part.runs.items())
    for record in sorted(submission.glob(f"{layout.TRAINED}/*.toml")):
        with contextlib.suppress(OSError, ValueError):
            runs = review.training_of(record.read_bytes()).runs
            yield from ((record.with_suffix(""), *run) for run in runs.items())


def _new_outcomes(run: LoggedRun, played: Played) -> Sequence[Sequence[Outcome]]:
    """The outcomes of all cells of a run on new seeds, which were played last."""
    return played.outcomes[-len(run.logged) :]


def _p_value(runs: Mapping[str, LoggedRun], draw: new_seeds.Draw, played: Mapping[str, Played]) -> float:
    """That of the logged returns against those on new seeds; 0 if policies fail."""
    if _failure(played):
        return 0.0
    numbers, stages, logged, new = [], [], [], []
    for number, (name, run) in enumerate(runs.items()):
        pairs = zip(run.logged.items(), _new_outcomes(run, played[name]), strict=True)
        for ((stage, _), prescribed), outcomes in pairs:
            numbers.append(number)
            stages.append(stage)
            logged.append([each.return_ for each in prescribed])
            new.append([each.return_ for each in outcomes])
    cells = new_seeds.CellReturns(*map(np.array, (numbers, stages, logged, new)))
    return new_seeds.compare(cells, np.random.default_rng(draw.seed("permutations")))


def _means(runs: Mapping[str, LoggedRun], played: Mapping[str, Played]) -> dict[str, str]:
    """The mean returns in each log and on new seeds, in words, by ``group/protocol``."""
    found = {}
    for log in dict.fromkeys(run.log.path for run in runs.values()):
        of_log = {name: run for name, run in runs.items() if run.log.path == log}
        logged = [cell for run in of_log.values() for cell in run.logged.values()]
        new = [cell for name, run in of_log.items() for cell in _new_outcomes(run, played[name])]
        before, now = (fmean(each.return_ for cell in cells for each in cell) for cells in (logged, new))
        found[log] = f"mean return {before:.1f} in the log, {now:.1f} on new seeds ({len(new)} cells)"
    return found
