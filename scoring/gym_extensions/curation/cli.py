"""``gym-extensions check-pr``, and ``gym-extensions maintain`` with what only maintainers do."""

import argparse
import json
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import get_args

from gym_extensions.baselines.cli import parse_names
from gym_extensions.catalog.protocol import IN_ORDER
from gym_extensions.curation import gate
from gym_extensions.curation.gate_report import comment, read_report
from gym_extensions.errors import BenchError, reports_mistakes, working
from gym_extensions.scoring.cli import print_text
from gym_extensions.submissions import fetch, manifest, reader, review
from gym_extensions.submissions.layout import MANIFEST, submission_folders
from gym_extensions.submissions.problem import count
from gym_extensions.verification import cli as verification, git, new_seeds, recorders, train_here


def gate_parser() -> argparse.ArgumentParser:
    """The arguments of ``check-pr``."""
    command = argparse.ArgumentParser(
        prog="gym-extensions check-pr",
        description="Check a pull request with a submission. Its files are read from git, and only "
        "--try-code executes any.",
        epilog="Exit status: 0 passed or code alone, 1 refused, 2 wrong usage.",
    )
    add = command.add_argument
    add("--base", default="main", metavar="BRANCH", help="target branch of the pull request (default: main)")
    add("--head", default="HEAD", metavar="COMMIT", help="last commit of the pull request (default: HEAD)")
    add("--repository", type=Path, default=Path(), metavar="DIR", help="a clone (default: this folder)")
    add("--try-code", action="store_true", help="train its code twice in a box, with the budget for trials")
    add("--number", type=int, metavar="N", help="number of the pull request, for the report")
    output = command.add_mutually_exclusive_group()
    output.add_argument("--json", action="store_true", help="print the report as JSON")
    output.add_argument("--comment", type=Path, metavar="REPORT", help="print a report as Markdown")
    output.add_argument("--labels", type=Path, metavar="REPORT", help="print the labels of a report")
    return command


@reports_mistakes
def check_pr(argv: Sequence[str] | None = None) -> int:
    """Checks a pull request, prints the report, and returns the exit status."""
    options = gate_parser().parse_args(argv)
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
    repository = git.Repository(options.repository)
    with working("checking the pull request"):
        report = gate.check_pull_request(
            *(repository, options.base, options.head, options.number), try_code=options.try_code
        )
    print_text(report.to_json() if options.json else comment(report))
    return 1 if report.verdict == "refused" else 0


def maintain_parser() -> argparse.ArgumentParser:
    """The arguments of ``maintain``."""
    command = argparse.ArgumentParser(prog="gym-extensions maintain", description="What maintainers do.")
    parts = command.add_subparsers(dest="command", required=True)
    decide = parts.add_parser(
        "decide",
        help="store a decision about a submission",
        description="Store a decision, with who made it and why, in the review of a submission.",
    )
    add = decide.add_argument
    add("submission", type=Path, metavar="SUBMISSION", help="a submission's folder")
    add("decision", choices=get_args(review.Action), help="the decision")
    add("--by", required=True, metavar="NAME", help="who decides")
    add("--reason", required=True, metavar="TEXT", help="why")
    landscapes = parts.add_parser(
        "landscapes",
        help="measure policies in worlds between and beyond those that they were trained in",
        description="Run the policies of the runs 0 to 4 at values between and beyond those of the tasks, "
        "and write landscapes/GROUP.json into the submission, unless it is up to date.",
    )
    diagnostics = parts.add_parser(
        "diagnostics",
        help="describe the networks of policies on published observations",
        description="Compute norms, ranks, inactive units and divergences of the policies of all runs, and "
        "write diagnostics/GROUP.json into the submission, unless it is up to date.",
    )
    poses = parts.add_parser(
        "poses",
        help="record the motion that pages show",
        description="Run logged episodes of the first sequential run again, and write poses/GROUP.json into "
        "the submission, unless it is up to date.",
    )
    for part in (poses, landscapes, diagnostics):
        add, several = part.add_argument, "a submission's folder, or a folder of them"
        add("submissions", nargs="+", type=Path, metavar="SUBMISSION", help=several)
        names = "comma-separated names of groups (default: all)"
        add("--groups", type=parse_names, default=[], metavar="NAMES", help=names)
        add("--again", action="store_true", help="also measure what is up to date")
        verification.add_options(part)
    train = parts.add_parser(
        "train-here",
        help="train the code of a submission in a box",
        description="Train the code of a submission in a box, on seeds that follow from the commit that "
        "merged it, and write the runs into the submission. An interrupted command can be repeated.",
    )
    add = train.add_argument
    add("submission", type=Path, metavar="SUBMISSION", help="a submission's folder; with --due, all of them")
    add("--protocol", default=IN_ORDER[0], choices=IN_ORDER, help="order of the tasks (default: %(default)s)")
    names, core = "comma-separated names of groups (default: those of the core)", train_here.CORE_GROUPS
    add("--groups", type=parse_names, default=core, metavar="NAMES", help=names)
    add("--runs", type=verification.positive, default=5, metavar="N", help="runs per group (default: 5)")
    value = "hexadecimal digits that became public after the merge, such as a beacon's randomness"
    add("--value", default="", metavar="HEX", help=value)
    add("--jobs", type=verification.positive, default=1, metavar="N", help="processes (default: 1)")
    trial = "a trial: train with the budget smoke into this folder; the submission stays as it is"
    add("--trial", type=Path, metavar="DIR", help=trial)
    only = train.add_mutually_exclusive_group().add_argument
    only("--due", action="store_true", help="only print which submissions have something to train")
    only("--take", type=Path, metavar="DIR", help="check and add what another job wrote into trained/")
    parts.add_parser("references", help="measure the references of custom groups", add_help=False)
    return command


@reports_mistakes
def maintain(argv: Sequence[str] | None = None) -> int:
    """Runs a command of maintainers and returns the exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments[:1] == ["references"]:
        from gym_extensions.baselines.references import main as references  # loads the agents

        return references(arguments[1:])
    options = maintain_parser().parse_args(arguments)
    if options.command == "train-here":
        return _train_here(options)
    if options.command == "decide":
        for option, text in (("--by", options.by), ("--reason", options.reason)):
            if not text.strip() or len(text) > manifest.LONG:
                message = f"It is empty or has more than {manifest.LONG} characters."
                raise BenchError("no-reason", message, option, "Say who decides, and why.")
        submission = _one(options.submission)
        today = datetime.now(UTC).date().isoformat()
        stated = {"by": options.by, "date": today, "reason": options.reason}
        review.add_to_review(submission, decisions=[review.Decision(action=options.decision, **stated)])
        return 0
    fetcher = fetch.Fetcher(options.cache / "policies", options.public_only)
    what = options.command, _existing(options.submissions), options.groups
    for line in recorders.write(*what, fetcher, options.jobs, again=options.again):
        print(line, flush=True)
    return 0


def _train_here(options: argparse.Namespace) -> int:
    value = new_seeds.require_value(options.value, "--value") if options.value else ""
    if options.due:
        wanted, due = train_here.wanted_runs(options.runs, options.protocol, options.groups), []
        for each in map(reader.read, _existing([options.submission])):
            if train_here.is_due(each, wanted):
                with verification.leaving_out(each.name):
                    train_here.version_and_record(each, value)
                    due.append(each.name)
        print(json.dumps(due))
        return 0
    submission = reader.read(_one(options.submission))
    if options.take:
        train_here.take(submission, options.take, value)
        return 0
    try:
        found = train_here.train_here(
            *(submission, options.runs, value),
            protocol=options.protocol,
            groups=options.groups,
            trial=options.trial,
            jobs=options.jobs,
        )
    except KeyboardInterrupt:
        print("Interrupted. What is finished is kept: repeat the command.", file=sys.stderr)
        return 130
    where = f"tried, in {options.trial}" if options.trial else "trained here"
    print(f"{submission.name}: {count(len(found.runs), 'run')} {where}.")
    for key, why in found.failed.items():
        print(f"{key} counts as the floor: {why}")
    return 0


def _existing(paths: list[Path]) -> list[Path]:
    """The folders of submissions. Raises ``BenchError`` if one has no manifest."""
    folders = submission_folders(paths)
    for folder in folders:
        if not (folder / MANIFEST).is_file():
            raise BenchError("no-such-folder", f"It has no {MANIFEST}.", str(folder), "Name a submission.")
    return folders


def _one(path: Path) -> Path:
    """The folder of the submission. Raises ``BenchError`` if it is none, or a folder of several."""
    folders = _existing([path])
    if len(folders) > 1:
        message = f"It has {len(folders)} submissions."
        raise BenchError("several-submissions", message, str(path), "Name one of them.")
    return folders[0]
