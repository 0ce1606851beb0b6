"""``gym-extensions reevaluate``: evaluates policies on new seeds and writes the record that pages show."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.rollouts.problem import Problem
from gym_extensions.scoring.reevaluation.record import FOLDER, ReevaluationRecord, write
from gym_extensions.scoring.reevaluation.reevaluate import Reevaluation, reevaluate
from gym_extensions.scoring.scorecard.model import NewSeeds


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions reevaluate",
        description="Evaluate the policies of a submission on new seeds and write the returns. The site "
        "shows them beside the logged ones. `score --reevaluate` makes the same test and writes nothing.",
        epilog="Exit status: 0 success, 1 the logged returns are refused, 2 wrong usage.",
    )
    command.add_argument("submission", type=Path, metavar="FOLDER", help="the submission's folder")
    command.add_argument(
        "--salt",
        required=True,
        help="64 hexadecimal digits, fixed after the submission, from which the seeds follow: those of "
        "`gym-extensions ledger salt`",
    )
    command.add_argument(
        "--out", type=Path, default=FOLDER, help="folder of the records (default: %(default)s)"
    )
    return command


def record_of(submission: str, result: Reevaluation) -> ReevaluationRecord:
    """The record of a re-evaluation without problems.

    Raises:
        BenchError: the submission has no policies.
    """
    if result.p_value is None:
        hint = "Submit the policy after every stage; docs/rollout-log.md describes the files."
        raise BenchError("no-policies", "The submission has no policies.", submission, hint)
    return ReevaluationRecord(
        submission=submission,
        is_complete=result.is_complete,
        new_seeds=NewSeeds(result.digest, result.salt, result.p_value),
        groups={name: dict(protocols) for name, protocols in result.scores.items()},
    )


def _show(problem: Problem) -> None:
    print(f"{problem.where}: {problem.rule}: {problem.message} {problem.hint}", file=sys.stderr)


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Evaluates, writes the record, prints its path and the test, and returns the exit status."""
    options = parser().parse_args(argv)
    name = options.submission.resolve().name
    result = reevaluate(options.submission, options.salt)
    for problem in result.problems:
        _show(problem)
    if result.problems:
        return 1
    path = write(options.out, record_of(name, result))
    print(f"{path}: {result.cells} cells of 20 episodes, p = {result.p_value:.2g}")
    return 0
