"""``gym-extensions verify``: repeats a submission's episodes, and runs its policies on new seeds."""

from __future__ import annotations

import argparse
import secrets
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich import progress as bars
from rich.console import Console

from gym_extensions.catalog.groups import with_custom
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.scoring.output.screen import count
from gym_extensions.submissions.fetch import Fetcher, cache_folder
from gym_extensions.submissions.layout import submission_folders
from gym_extensions.submissions.poses import write
from gym_extensions.submissions.reader import read
from gym_extensions.verification.episodes import Store
from gym_extensions.verification.new_seeds import ALPHA, require_value
from gym_extensions.verification.pose_recorder import poses_of
from gym_extensions.verification.verify import Report, add_verifications, runs_of, verify

NOTHING_LEFT = "no run with policies is left to verify; each is verified once."
SUBMISSION_HELP = "a submission's folder, or a folder of submissions"
EPILOG = """Exit status: 0 all submissions are verified, 1 one is not or has problems, 2 wrong usage."""


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions verify",
        description="Check the rules, repeat all logged episodes with the stored policies where these are "
        "deterministic, and compare the logged returns with those on new seeds. It can be interrupted and "
        "called again with the same --seeds.",
        epilog=EPILOG,
    )
    add = command.add_argument
    add("submissions", nargs="+", type=Path, metavar="SUBMISSION", help=SUBMISSION_HELP)
    add("--groups", action="append", default=[], metavar="FILE", help="the TOML file of a custom group")
    digits = "hexadecimal digits (40 to 128) that determine the new seeds, such as the id of the merge commit"
    add("--seeds", metavar="HEX", help=f"{digits} (default: random)")
    add("--retrain", action="store_true", help="also train one random run again (reference agents only)")
    add_options(command)
    stored = "store the result in the submission's review.toml; needs --seeds"
    add("--write", action="store_true", help=stored)
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


def verified(
    path: Path, value: str, options: argparse.Namespace, files: Sequence[str] = (), **which: Any
) -> Report:
    """The report on one submission, with a progress bar; see :func:`verify`."""
    console = Console(stderr=True)
    columns = (
        *(bars.TextColumn("{task.description}"), bars.BarColumn(), bars.MofNCompleteColumn()),
        *(bars.TextColumn("cells"), bars.TimeElapsedColumn(), bars.TextColumn("left:")),
        bars.TimeRemainingColumn(),
    )
    with bars.Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as progress:
        task = progress.add_task(path.name, total=None)

        def started(cells: int) -> None:
            progress.update(task, total=(progress.tasks[task].total or 0) + cells)

        return verify(
            *(path, value, Store(options.cache / "verify")),
            Fetcher(options.cache / "policies", options.public_only),
            **which,
            files=files,
            jobs=options.jobs,
            started=started,
            done=lambda cells: progress.advance(task, cells),
        )


def _verified_and_trained(
    path: Path, value: str, options: argparse.Namespace, files: Sequence[str]
) -> Report:
    """The report on one submission, after one drawn run was trained again if the options ask for it."""
    if not options.retrain:
        return verified(path, value, options, files, only_new=options.write)
    from gym_extensions.verification import retrain  # loads the agents

    groups = with_custom(files)
    retrain.require_reference_agent(path, groups)
    return retrain.retrained(path, verified(path, value, options, files, only_new=options.write), groups)


def write_poses(path: Path, report: Report) -> None:
    """Writes the poses of the first sequential run of every published group that was verified."""
    if report.verification is None or not report.verification.passed:
        return
    submission = read(path, merge_runs=False)
    for name, run in runs_of(submission).items():
        is_first = run.log.protocol == "sequential" and run.document.run == run.log.runs[0]
        is_elsewhere = run.document.policies is not None and run.document.policies.url
        if is_first and name in report.verification.runs and not is_elsewhere:
            write(path, run.log.group.name, poses_of(run, submission, path))


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
    found = report.verification
    if found is None:
        if not report.without_policies:
            yield f"{report.name}: {NOTHING_LEFT}"
        return
    size = count(len(found.runs), "run")
    yield f"{report.name}: {'verified' if found.passed else 'NOT verified'}, {size}."
    if report.retraining:
        yield f"  trained again: {report.retraining}"
    if not report.means:
        yield f"  the policies cannot be run: {found.difference}"
        return
    if report.runs:
        how = f"by {found.runtime}, returns within .1 %" if found.runtime else "bit for bit"
        yield f"  repeated {how}: {found.repeated:,} of {found.episodes:,} episodes"
    else:
        yield "  repeated: none, because the policies sample their actions"
    if found.difference:
        yield f"  first difference: {found.difference}"
    for machine in dict.fromkeys(report.machines.values()):
        yield f"  made elsewhere (run / here): {machine}; a difference neither raises nor lowers the level"
    yield from (f"  {log}: {returns}" for log, returns in report.means.items())
    second = "" if found.second_p_value is None else f"; second draw: p = {found.second_p_value:.2g}"
    yield f"  new seeds: p = {found.p_value:.2g}{second} (refused up to {ALPHA}), from {found.value}"


def is_verified(report: Report) -> bool:
    """Whether nothing speaks against the submission, and all its runs have policies."""
    passed = report.verification is None or report.verification.passed
    return passed and not report.problems and not report.without_policies


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Verifies, prints what it found, and returns the exit status."""
    command = parser()
    options = command.parse_args(argv)
    if options.write and not options.seeds:
        hint = "Pass --seeds with the id of the merge commit or a beacon's randomness."
        raise BenchError("no-seeds", "A stored verification needs seeds that nobody chose.", "--write", hint)
    value = require_value(options.seeds) if options.seeds else secrets.token_hex(32)
    status = 0
    files = [str(Path(file).resolve()) for file in options.groups]
    for path in submission_folders(options.submissions):
        try:
            report = _verified_and_trained(path, value, options, files)
        except BenchError as error:
            print(f"error: {error}", file=sys.stderr)
            status = 2
            continue
        except KeyboardInterrupt:
            print(f"Interrupted. What is finished is kept: add --seeds {value}", file=sys.stderr)
            return 130
        print("\n".join(lines_of(report)))
        status = max(status, int(not is_verified(report)))
        if options.write and report.verification is not None:
            add_verifications(path, report.verification)
            write_poses(path, report)
    if not options.seeds:
        print("The seeds were drawn at random on this machine: the result is a trial and is not stored.")
    return status
