"""``gym-extensions check-pr``, and ``gym-extensions maintain`` with what only maintainers do."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.curation import after_merge
from gym_extensions.curation.gate import check_pull_request
from gym_extensions.curation.gate_report import comment, read_report
from gym_extensions.curation.git import Repository
from gym_extensions.curation.pull_request_rules import RULES
from gym_extensions.errors import BenchError, reports_mistakes, working
from gym_extensions.files import write_text
from gym_extensions.scoring.cli import print_text
from gym_extensions.submissions.fetch import Fetcher
from gym_extensions.submissions.layout import DOCUMENT, MANIFEST, submission_folders
from gym_extensions.submissions.review import Action, Review, review_text
from gym_extensions.submissions.run import read_run
from gym_extensions.verification import cli as verification
from gym_extensions.verification.landscape_recorder import measure_all
from gym_extensions.verification.verify import add_verifications


def gate_parser() -> argparse.ArgumentParser:
    """The arguments of ``check-pr``."""
    command = argparse.ArgumentParser(
        prog="gym-extensions check-pr",
        description="Check a pull request with a submission. Its files are read from git and never executed.",
        epilog="Exit status: 0 passed or code alone, 1 refused, 2 wrong usage.",
    )
    add = command.add_argument
    add("--base", default="main", metavar="BRANCH", help="target branch of the pull request (default: main)")
    add("--head", default="HEAD", metavar="COMMIT", help="last commit of the pull request (default: HEAD)")
    add("--repository", type=Path, default=Path(), metavar="DIR", help="a clone (default: this folder)")
    add("--number", type=int, metavar="N", help="number of the pull request, for the report")
    output = command.add_mutually_exclusive_group()
    output.add_argument("--json", action="store_true", help="print the report as JSON")
    output.add_argument("--rules", action="store_true", help="print the rules")
    output.add_argument("--comment", type=Path, metavar="REPORT", help="print a report as Markdown")
    output.add_argument("--labels", type=Path, metavar="REPORT", help="print the labels of a report")
    return command


@reports_mistakes
def check_pr(argv: Sequence[str] | None = None) -> int:
    """Checks a pull request, prints the report, and returns the exit status."""
    options = gate_parser().parse_args(argv)
    if options.rules:
        print_text("".join(f"{each.name}: {each.text}\n" for each in RULES.values()))
        return 0
    if path := options.comment or options.labels:
        try:
            report = read_report(path.read_bytes())
        except OSError as error:
            raise BenchError("no-report", f"{error.strerror}.", str(path), "Name a file.") from None
        print_text(comment(report) if options.comment else "".join(f"{each}\n" for each in report.labels))
        return 0
    if sys.platform == "win32":
        message = "Windows has no limits on memory and processor time."
        raise BenchError("no-limits", message, "check-pr", "Run it on Linux or macOS.")
    repository = Repository(options.repository)
    with working("checking the pull request"):
        report = check_pull_request(repository, options.base, options.head, options.number)
    print_text(report.to_json() if options.json else comment(report))
    return 1 if report.verdict == "refused" else 0


def maintain_parser() -> argparse.ArgumentParser:
    """The arguments of ``maintain``."""
    command = argparse.ArgumentParser(prog="gym-extensions maintain", description="What maintainers do.")
    parts = command.add_subparsers(dest="command", required=True)
    review = parts.add_parser(
        "review",
        help="verify what was merged, or store a decision",
        description="Verify every run that has no verdict yet, with seeds from the commit that "
        "merged it, and write the result into its review. With --decision, store a decision of a maintainer.",
        epilog="Exit status: 0 verified or recorded, 1 a submission is not verified, 2 wrong usage.",
    )
    add = review.add_argument
    add("submissions", nargs="+", type=Path, metavar="SUBMISSION", help=verification.SUBMISSION_HELP)
    verification.add_options(review)
    only = review.add_mutually_exclusive_group().add_argument
    only("--record", type=Path, metavar="DIR", help="write the result to a file in DIR, not to the review")
    only("--take", type=Path, metavar="FILE", help="check a file of --record, and add it to the review")
    only("--fetch", action="store_true", help="only fetch policies that lie elsewhere into the cache")
    only("--decision", choices=get_args(Action), help="the decision")
    add("--by", default="", metavar="NAME", help="who decides")
    add("--reason", default="", metavar="TEXT", help="why")
    help_ = "also train one randomly chosen run again (reference agents with a budget of at most 300k)"
    add("--retrain-own", action="store_true", help=help_)
    landscapes = parts.add_parser(
        "landscapes",
        help="measure policies in worlds between and beyond those that they were trained in",
        description="Run the policies of the runs 0 to 4 at values between and beyond those of the tasks, "
        "and write landscapes/GROUP.json into the submission, unless it is up to date.",
    )
    add = landscapes.add_argument
    add(
        "submissions",
        nargs="+",
        type=Path,
        metavar="SUBMISSION",
        help="a submission's folder, or a folder of them",
    )
    add("--groups", nargs="+", default=[], metavar="NAME", help="gravity, body or wall groups (default: all)")
    add("--again", action="store_true", help="also measure what is up to date")
    verification.add_options(landscapes)
    parts.add_parser("references", help="measure the references of custom groups", add_help=False)
    return command


@reports_mistakes
def maintain(argv: Sequence[str] | None = None) -> int:
    """Runs a command of maintainers and returns the exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments[:1] == ["references"]:
        from gym_extensions.baselines.references import main as references  # loads the agents

        return references(arguments[1:])
    command = maintain_parser()
    options = command.parse_args(arguments)
    if options.command == "review":
        return _review(command, options)
    fetcher = Fetcher(options.cache / "policies", options.public_only)
    submissions = _existing(options.submissions)
    for line in measure_all(submissions, options.groups, fetcher, options.jobs, options.again):
        print(line, flush=True)
    return 0


def _existing(paths: list[Path]) -> list[Path]:
    """The folders of submissions. Raises ``BenchError`` if one has no manifest."""
    folders = submission_folders(paths)
    for folder in folders:
        if not (folder / MANIFEST).is_file():
            raise BenchError("no-such-folder", f"It has no {MANIFEST}.", str(folder), "Name a submission.")
    return folders


def _review(command: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    submissions = submission_folders(options.submissions)
    if (options.decision or options.take) and len(submissions) != 1:
        command.error("--decision and --take are about one submission")
    if (options.by or options.reason) and not options.decision:
        command.error("--by and --reason belong to --decision")
    if options.decision:
        after_merge.decide(_existing(submissions)[0], options.decision, options.by, options.reason)
        return 0
    if options.take:
        after_merge.take(submissions[0], options.take)
        return 0
    status = 0
    for each in submissions:
        try:
            found = review_submission(each, options)
        except (BenchError, OSError) as error:
            print(f"error: {error}", file=sys.stderr)
            found = 2
        except KeyboardInterrupt:
            print("Interrupted. What is finished is kept: repeat the command.", file=sys.stderr)
            return 130
        status = max(status, found)
    return status


def review_submission(submission: Path, options: argparse.Namespace) -> int:
    """Verifies the undecided runs of a submission, records the result, and returns the exit status.

    Raises:
        BenchError: the submission has problems, or cannot be verified at the moment. Nothing is recorded
            then.
    """
    runs = after_merge.undecided_runs(submission)
    if not runs:
        print(f"{submission.name}: {verification.NOTHING_LEFT}")
        return 0
    if options.fetch:
        fetcher = Fetcher(options.cache / "policies", options.public_only)
        for name in runs:
            policies = read_run(submission / f"{name}{DOCUMENT}").policies
            if policies is not None and policies.url:
                fetcher.fetch(policies, name)
        return 0
    status, found = 0, []
    for value, names in after_merge.runs_by_commit(submission, runs).items():
        report = verification.verified(submission, value, options, only=names)
        if options.retrain_own and after_merge.is_trained_again(submission):
            from gym_extensions.verification import retrain  # loads the agents

            try:
                report = retrain.retrained(submission, report, GROUPS)
            except BenchError as error:  # what was verified counts
                report = replace(report, retraining=f"not possible: {error}")
        print("\n".join(verification.lines_of(report)))
        status |= not verification.is_verified(report)
        found += [report.verification] if report.verification else []
        if options.record:
            write_text(options.record / f"{submission.name}.toml", review_text(Review(verifications=found)))
        elif report.verification:
            add_verifications(submission, report.verification)
            verification.write_poses(submission, report)
    return status
