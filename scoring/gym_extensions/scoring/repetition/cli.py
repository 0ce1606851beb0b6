"""``gym-extensions repeat``: repeats the episodes of a submission and records the runs that agree."""

from __future__ import annotations

import argparse
from pathlib import Path

from gym_extensions.errors import reports_mistakes
from gym_extensions.installed import blas_kernels
from gym_extensions.rollouts.folder import scan
from gym_extensions.scoring.repetition.digests import run_digests
from gym_extensions.scoring.repetition.record import FOLDER, RepeatedRun, RepetitionRecord, load, write
from gym_extensions.scoring.repetition.repeat import read_submission
from gym_extensions.scoring.repetition.runs import repeat


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions repeat",
        description="Repeat all episodes of a submission with its policies, compare them with the log bit by "
        "bit, and write the runs that agree. Runs that the record has already are left out, so that "
        "a call with other BLAS kernels (OPENBLAS_CORETYPE) can repeat the others.",
        epilog="Exit status: 0 all runs are repeated, 1 some are not, 2 wrong usage.",
    )
    command.add_argument("submission", type=Path, metavar="FOLDER", help="the submission's folder")
    command.add_argument(
        "--out", type=Path, default=FOLDER, help="folder of the records (default: %(default)s)"
    )
    command.add_argument("--jobs", type=int, default=1, help="worker processes (default: 1)")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Repeats, writes the record after every run, prints each run, and returns the exit status."""
    command = parser()
    options = command.parse_args(argv)
    if options.jobs < 1:
        command.error("--jobs takes a number from 1")
    path: Path = options.submission
    submission, kernels, name = read_submission(path), blas_kernels(), path.resolve().name
    digests = run_digests(submission, scan(path))
    record = (load(options.out, name) or RepetitionRecord(submission=name)).of(digests)
    for run in repeat(path, {each.key for each in record.runs}, jobs=options.jobs):
        if run.difference:
            print(f"{run.key}: differs at {run.difference}", flush=True)
            continue
        print(f"{run.key}: {run.episodes} episodes are repeated", flush=True)
        group, protocol, number = run.key.group, run.key.protocol, run.key.run
        record = record.with_run(
            RepeatedRun(group, protocol, number, run.episodes, kernels, digests[run.key])
        )
        write(options.out, record)
    if record.covers(digests):
        episodes = sum(each.episodes for each in record.runs)
        print(f"{name}: all {episodes:,} episodes are repeated.")
        return 0
    versions = submission.manifest.versions if submission.manifest else None
    made = (versions and versions.blas) or "unknown"
    print(f"{name}: some runs are not repeated. {_reason(made, kernels, all(digests.values()))}")
    return 1


def _reason(made: str, kernels: str, has_policies: bool) -> str:
    """What may explain that an honest log is not repeated."""
    if not has_policies:
        return "Some logs have no policies, without which nothing can be repeated."
    if made != kernels:
        return (
            f"The log was made with the BLAS kernels {made}, and this process has {kernels}. With other "
            "kernels an honest log is not repeated."
        )
    return "The BLAS kernels are those of the log."
