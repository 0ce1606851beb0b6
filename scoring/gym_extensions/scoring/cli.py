"""The ``score`` command: checks, scores and prints submissions."""

from __future__ import annotations

import argparse
import os
import sys
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from gym_extensions.errors import BenchError, reports_mistakes

if TYPE_CHECKING:
    from gym_extensions.scoring.pipeline.evidence import Evidence
    from gym_extensions.scoring.pipeline.score import Scorer
    from gym_extensions.scoring.scorecard.model import Scorecard, ScorecardDocument

MAX_IN_FULL = 3
"""Up to this many submissions are printed in full; beyond it, one line each plus problems."""


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="score",
        description="Check submissions, score them and print their scorecards.",
        epilog="Exit status: 0 no problem, 1 a submission has problems, 2 wrong usage.",
    )
    add = command.add_argument
    add("folders", nargs="*", type=Path, metavar="FOLDER", help="a submission, or a folder of submissions")
    output = command.add_mutually_exclusive_group()
    output.add_argument("--json", action="store_true", help="print scorecards as JSON (docs/scorecard.md)")
    output.add_argument("--csv", action="store_true", help="print one CSV row per metric")
    output.add_argument("--markdown", action="store_true", help="print Markdown tables")
    add("--compare", nargs=2, type=Path, metavar=("A", "B"), help="compare two submissions by metric")
    add(
        "--groups",
        action="append",
        default=[],
        metavar="FILE",
        help="also accept the custom group in this TOML file; may be repeated",
    )
    add("--references", type=Path, metavar="FILE", help="references of the custom groups' tasks")
    add("--verify", action="store_true", help="also replay the recorded episodes in the simulator")
    add(
        "--salt",
        metavar="HEX",
        help="64 hexadecimal digits that were fixed after the submission: with --verify, the traces must "
        "have been drawn with it; with --reevaluate, the new seeds follow from it",
    )
    add(
        "--reevaluate",
        action="store_true",
        help="also replay the recorded episodes, and evaluate the policies on new seeds",
    )
    add("--archive", type=Path, metavar="ZIP", help="also check the archive of all traces of one submission")
    out_help = (
        "write scorecards/NAME.json and boards.json to DIR; scorecards of other submissions in it are removed"
    )
    add("--out", type=Path, metavar="DIR", help=out_help)
    add("--jobs", type=int, metavar="N", help="worker processes (default: CPU count + 1)")
    add("--version", action="version", version=version("gym-extensions"))
    return command


def parse_args(argv: list[str] | None) -> argparse.Namespace:
    """The options of a command line; exits with status 2 where they are wrong."""
    command = parser()
    options = command.parse_args(argv)
    if not options.folders and not options.compare:
        command.error("name at least one FOLDER, or two with --compare")
    others = ("folders", "csv", "markdown", "out", "verify", "jobs", "salt", "reevaluate", "archive")
    if options.compare and any(getattr(options, name) for name in others):
        command.error("--compare takes two submissions and only --json, --groups and --references besides")
    if options.salt is not None and not (options.verify or options.reevaluate):
        command.error("--salt needs --verify or --reevaluate")
    if options.reevaluate and options.salt is None:
        command.error("--reevaluate needs --salt")
    if options.jobs is not None and options.jobs < 1:
        command.error("--jobs takes a number from 1")
    return options


def _print(text: str) -> None:
    """Writes text to standard output as UTF-8, whatever the locale is."""
    sys.stdout.flush()
    sys.stdout.buffer.write(text.encode())
    sys.stdout.buffer.flush()


def _scorer(options: argparse.Namespace) -> Scorer:
    from gym_extensions.scoring.pipeline.score import make_scorer

    return make_scorer(options.groups, options.references)


def _compare(paths: list[Path], scorer: Scorer, as_json: bool) -> int:
    from gym_extensions.scoring.leaderboard.compare import compare
    from gym_extensions.scoring.output import summary
    from gym_extensions.scoring.output.console import console
    from gym_extensions.scoring.pipeline.score import find_submissions

    cards = []
    for path in paths:
        folders = find_submissions([path])
        if len(folders) != 1:
            hint = "Name two submissions."
            raise BenchError("bad-compare", f"It contains {len(folders)} submissions.", str(path), hint)
        cards.append(scorer(folders[0]))
    refused = [card for card in cards if card.problems]
    for card in refused:
        summary.show_line(console(errors=as_json), card)
    if refused:
        return 1
    comparison = compare(*cards)
    if as_json:
        _print(comparison.to_json())
    else:
        summary.show_comparison(console(), comparison)
    return 0


def _score(options: argparse.Namespace) -> int:
    from gym_extensions.scoring.output import summary
    from gym_extensions.scoring.output.console import console
    from gym_extensions.scoring.pipeline import score as pipeline
    from gym_extensions.scoring.pipeline.publish import Publisher

    scorer = _scorer(options)
    references = scorer.references
    info = pipeline.references_info(references)
    folders = pipeline.find_submissions(options.folders)
    as_text = options.json or options.csv or options.markdown
    publisher = Publisher(options.out, references) if options.out else None
    cards: list[Scorecard] = []
    out, problems = console(), False
    for card in pipeline.scorecards(folders, scorer, options.jobs, evidence=_evidence(options, len(folders))):
        problems = problems or bool(card.problems)
        try:
            if as_text:
                cards.append(card)
            elif len(folders) > MAX_IN_FULL:
                summary.show_line(out, card)
            else:
                summary.show(out, card, info)
        except BrokenPipeError:
            if not publisher:
                raise
            _discard_output()
        if publisher:
            publisher.add(card)
    if publisher:
        publisher.finish()
    if as_text:
        _print(_as_text(pipeline.scorecard_document(cards, references), options))
    return 1 if problems else 0


def _evidence(options: argparse.Namespace, submissions: int) -> Evidence:
    from gym_extensions.rollouts.auditing.salt import require_salt
    from gym_extensions.scoring.pipeline.evidence import Evidence

    if options.salt is not None:
        require_salt(options.salt, "--salt")
    if options.archive is not None and submissions != 1:
        raise BenchError("bad-archive", f"There are {submissions} submissions.", "--archive", "Name one.")
    return Evidence(options.verify, options.salt, options.reevaluate, options.archive)


def _as_text(document: ScorecardDocument, options: argparse.Namespace) -> str:
    if options.json:
        return document.to_json()
    from gym_extensions.scoring.output.tables import csv_text, markdown_text  # loads pandas

    return csv_text(document) if options.csv else markdown_text(document)


def _discard_output() -> None:
    """Sends what is still printed to the null device."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command and returns the exit status."""
    options = parse_args(argv)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        return (
            _compare(options.compare, _scorer(options), options.json) if options.compare else _score(options)
        )
    except BrokenPipeError:
        _discard_output()
        return 1
    except OSError as error:
        message, path = f"{error.strerror or error}.", str(error.filename or "")
        raise BenchError("not-written", message, path, "Choose another folder for --out.") from error
