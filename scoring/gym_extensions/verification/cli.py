"""``gym-extensions verify``: repeats a submission's episodes, and runs its policies on new seeds."""

import argparse
import json
import os
import secrets
import sys
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from gym_extensions.catalog.groups import with_custom
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.files import write_text
from gym_extensions.submissions import layout, reader, review
from gym_extensions.submissions.fetch import Fetcher, cache_folder
from gym_extensions.submissions.problem import count, refuse_problems
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification import after_merge, episodes, git
from gym_extensions.verification.logged_run import logged_runs
from gym_extensions.verification.new_seeds import require_value
from gym_extensions.verification.verify import Report, settings_of, verify

OTHERS = "other processors do not repeat"
EPILOG = """\
Without --seeds, --write and --record verify the runs that have no verdict yet, with seeds from the commit \
that merged them. Exit status: 0 all submissions are verified, 1 one is not or has problems, 2 wrong usage."""


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions verify",
        description="Check the rules, repeat all logged episodes with the stored policies where these are "
        "deterministic, and compare the logged returns with those on new seeds. Without further options the "
        "seeds are random and nothing is stored. It can be interrupted and called again with the same seeds.",
        epilog=EPILOG,
    )
    add = command.add_argument
    folders = "a submission's folder, or a folder of submissions"
    add("submissions", nargs="+", type=Path, metavar="SUBMISSION", help=folders)
    group = "the TOML file of a custom group"
    add("--groups", action="append", default=[], type=os.path.abspath, metavar="FILE", help=group)
    digits = "hexadecimal digits (40 to 128) that determine the new seeds, such as a beacon's randomness"
    add("--seeds", metavar="HEX", help=digits)
    again = "also train one random run again (reference agents; with --record, budgets up to 300k)"
    add("--retrain", action="store_true", help=again)
    time = "processor time for a submission; one that needs more is undecided (default: %(default)g)"
    add("--hours", type=float, default=episodes.HOURS, metavar="N", help=time)
    only = command.add_mutually_exclusive_group().add_argument
    only("--write", action="store_true", help="store the result in the submission's review.toml")
    only("--record", type=Path, metavar="DIR", help="write the result to a file in DIR, not to the review")
    only("--take", type=Path, metavar="FILE", help="check a file of --record, and add it to the review")
    only("--due", action="store_true", help="only print which submissions wait for it, the newest last")
    only("--fetch", action="store_true", help="only fetch policies that lie elsewhere into the cache")
    add_options(command)
    return command


def add_options(command: argparse.ArgumentParser) -> None:
    """The arguments of commands that run policies."""
    add = command.add_argument
    add("--jobs", type=positive, default=1, metavar="N", help="processes that work at once (default: 1)")
    add("--public-only", action="store_true", help="download policies from public https addresses only")
    cache = "cache of downloaded policies and finished episodes; may be deleted"
    add("--cache", type=Path, default=cache_folder(), metavar="DIR", help=cache)


def positive(text: str) -> int:
    """The number of an option. Raises ``ValueError`` unless it is an integer from 1."""
    if int(text) < 1:
        raise ValueError
    return int(text)


def verify_with_progress(
    submission: Submission,
    value: str,
    names: Collection[str] | None,
    player: episodes.Player,
    options: argparse.Namespace,
) -> Report:
    """The report on runs of one submission, with a progress bar; see :func:`verify`."""
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(submission.name, total=None)

        def started(cells: int) -> None:
            progress.update(task, total=(progress.tasks[task].total or 0) + cells)

        player.started, player.done = started, partial(progress.advance, task)
        fetcher = Fetcher(options.cache / "policies", options.public_only)
        is_trial = not (options.write or options.record)
        return verify(submission, value, player, fetcher, names, is_trial=is_trial)


def reports_on(submission: Submission, value: str, options: argparse.Namespace) -> Iterator[Report]:
    """The report on each part of a submission that is verified with the same seeds.

    ``value`` determines the seeds; if it is empty, they follow from the commits that merged the runs. If the
    result is stored, only runs without a verdict are verified. One drawn run of each part is trained again if
    the options ask for it.

    Raises:
        BenchError: the submission cannot be verified at the moment, or not be trained again.
    """
    if submission.problems:
        yield Report(submission.name, submission.problems)
        return
    parts: Mapping[str, Collection[str] | None] = {value: None}
    if options.write or options.record:
        waiting = after_merge.runs_without_verdict(submission, again=options.write)
        by_commit = {} if value else after_merge.runs_by_commit(submission.path, waiting)
        parts = by_commit or {value: waiting}
    is_job = bool(options.record)  # it keeps what it verified if nothing can be trained again
    is_retrained = options.retrain and (not is_job or after_merge.is_trained_again(submission))
    if is_retrained:
        from gym_extensions.verification import retrain  # loads the agents

        if not is_job:  # before hours are spent
            retrain.reference_agent(submission)
    repository = git.Repository(submission.path)
    player = episodes.Player(options.cache / "verify", options.groups, options.jobs, options.hours)
    for seeds, names in parts.items():
        if seeds != value and (problem := repository.not_merged(seeds)):
            yield Report(submission.name, (problem,))
            continue
        report = verify_with_progress(submission, seeds, names, player, options)
        if is_retrained:
            try:
                report = retrain.retrained(submission, report)
            except BenchError as error:
                if not is_job:
                    raise
                report = replace(report, retraining=f"not possible: {error}")
        yield report


def lines_of(report: Report) -> Iterator[str]:
    """The report in words, a line each."""
    if report.problems:
        yield f"{report.name}: {count(len(report.problems), 'problem')}; nothing was run."
        yield from (f"  {each.where}: {each.rule}: {each.message} {each.hint}" for each in report.problems)
        return
    if report.without_policies:
        names, runs = ", ".join(report.without_policies[:3]), len(report.without_policies)
        more = "…" if runs > 3 else ""
        yield f"{report.name}: {count(runs, 'run')} without policies, claimed only: {names}{more}."
    if left_out := not_run(report):
        yield f"{report.name}: {count(len(left_out), 'run')} of the first arithmetic, which {OTHERS}."
        command = f"python -m tools.record_again submissions/{report.name}"
        yield f"  Their level stays. To record them again: {command}"
    record = report.verification
    if record is None:
        if not report.without_policies and not left_out:
            yield f"{report.name}: no run with policies is left to verify; each is verified once."
        return
    size = count(len(record.runs), "run")
    yield f"{report.name}: {record.undecided or ('verified' if record.passed else 'NOT verified')}, {size}."
    if report.retraining:
        yield f"  trained again: {report.retraining}"
    if report.means:
        yield from results_of(report, record)
    elif not record.undecided:
        yield f"  the policies cannot be run: {record.difference}"


def results_of(report: Report, record: review.Verification) -> Iterator[str]:
    """What the policies did, in words, a line each."""
    if report.repetitions:
        how = review.how_repeated(record.runtime)
        yield f"  repeated {how}: {record.repeated:,} of {record.episodes:,} episodes"
    if len(report.repetitions) < len(record.runs):
        first = f"{count(len(report.first_arithmetic), 'run')} of the first arithmetic, which {OTHERS}"
        yield f"  not repeated: {first if report.first_arithmetic else 'the policies sample their actions'}"
    if report.twins:
        yield f"  one run twice: {report.twins}"
    elif record.difference:
        yield f"  first difference: {record.difference}"
    for other_machine in dict.fromkeys(each.other_machine for each in report.repetitions.values()):
        if other_machine:
            yield f"  {other_machine} A difference neither raises nor lowers the level."
    yield from (f"  {log}: {returns}" for log, returns in report.means.items())
    second = "" if record.second_p_value is None else f"; second draw: p = {record.second_p_value:.2g}"
    refused = f"refused up to {review.NEW_SEEDS_ALPHA}"
    yield f"  new seeds: p = {record.p_value:.2g}{second} ({refused}), from {record.value}"


def is_verified(report: Report) -> bool:
    """Whether nothing speaks against the submission, and all its runs have policies that can be repeated."""
    passed = report.verification is None or report.verification.passed
    return passed and not (report.problems or report.without_policies or not_run(report))


def not_run(report: Report) -> set[str]:
    """The names of the runs of the first arithmetic that were not run: no result of them is stored."""
    return set(report.first_arithmetic) - set(report.verification.runs if report.verification else ())


def verify_folder(path: Path, value: str, options: argparse.Namespace) -> int:
    """Verifies a submission, or only fetches its policies, and returns the exit status.

    Raises:
        BenchError: it is not possible at the moment.
    """
    submission, is_stored = reader.read(path, with_custom(options.groups)), options.write or options.record
    if options.fetch:
        refuse_problems(submission.path, submission.problems)
        fetcher, runs = Fetcher(options.cache / "policies", options.public_only), logged_runs(submission)
        for name in after_merge.runs_without_verdict(submission):
            runs[name].request(fetcher=fetcher)
        return 0
    if submission.code and not (submission.groups or submission.problems):
        trained = submission.trained
        if trained is None or trained.runs.manifest is None or is_stored:
            print(f"{submission.name}: it has no runs of its own; its code is trained after the merge.")
            return 0
        submission = replace(trained.runs, name=submission.name)
    status, records = 0, list[review.Verification]()
    for report in reports_on(submission, value, options):
        print("\n".join(lines_of(report)))
        status |= not is_verified(report)
        if report.verification is None:
            continue
        records.append(report.verification)
        if options.record:
            text = review.review_text(review.Review(verifications=records))
            write_text(options.record / f"{submission.name}.toml", text)
        elif options.write:
            review.add_to_review(path, [report.verification])
    if is_stored and not submission.problems:
        known = review.Review(verifications=[*submission.review.verifications, *records])
        digests = {name: document.digest for name, document in submission.documents.items()}
        why = review.why_claimed(known, settings_of(submission), digests)
        if why and not records:
            print(f"  claimed: {why}")
        status |= bool(why)
    return status


@contextmanager
def leaving_out(name: str) -> Iterator[None]:
    """Says on standard error that an error leaves a submission out, unless it is one of this machine."""
    try:
        yield
    except BenchError as error:
        if error.code in git.MACHINE_ERRORS:
            raise
        print(f"{name} is left out: {error}", file=sys.stderr)


def due(folders: Sequence[Path]) -> list[str]:
    """The names of the submissions with merged runs that have no verdict, the newest last."""
    merged = dict[str, int]()
    for submission in map(reader.read, folders):
        with leaving_out(submission.name):
            refuse_problems(submission.path, submission.problems)
            merged[submission.name] = after_merge.merged_at(submission)
    return sorted((name for name, time in merged.items() if time), key=merged.__getitem__)


def require_writable(cache: Path) -> None:
    """Raises ``BenchError`` if nothing can be written into the cache, before hours are spent."""
    try:
        cache.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=cache).close()
    except OSError as error:
        message, hint = f"It is not writable: {error.strerror or error}.", "Name another: --cache DIR."
        raise BenchError("bad-cache", message, str(cache), hint) from error


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Verifies, prints what it found, and returns the exit status."""
    command = parser()
    options = command.parse_args(argv)
    folders = layout.submission_folders(options.submissions)
    if options.due:
        print(json.dumps(due(folders)))
        return 0
    if options.take:
        if len(folders) != 1:
            command.error("--take is about one submission")
        submission = reader.read(folders[0], with_custom(options.groups))
        refuse_problems(submission.path, submission.problems)
        after_merge.take(submission, options.take)
        return 0
    value = require_value(options.seeds, "--seeds") if options.seeds else ""
    is_trial = not (value or options.write or options.record or options.fetch)
    if is_trial:
        value = secrets.token_hex(32)
    require_writable(options.cache)
    status = 0
    for path in folders:
        try:
            status = max(status, verify_folder(path, value, options))
        except (BenchError, OSError) as error:
            print(f"error: {error}", file=sys.stderr)
            status = 2
        except KeyboardInterrupt:
            again = f"add --seeds {value}" if value else "repeat the command"
            print(f"Interrupted. What is finished is kept: {again}", file=sys.stderr)
            return 130
    if is_trial:
        print("The seeds were drawn at random on this machine: the result is a trial and is not stored.")
    return status
