"""The ``score`` command: checks, scores and prints submissions."""

import argparse
import sys
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from gym_extensions.errors import BenchError, reports_mistakes

if TYPE_CHECKING:
    from gym_extensions.scoring.pipeline import Scorer
    from gym_extensions.scoring.scorecard import Scorecard

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
    add(
        "--compare",
        nargs=2,
        type=Path,
        metavar=("A", "B"),
        help="compare two submissions by metric, the core first",
    )
    help_ = "score only this group (or core), in full; may be repeated"
    add("--group", action="append", default=[], metavar="NAME", help=help_)
    help_ = "also accept the custom group in this TOML file; may be repeated"
    add("--groups", action="append", default=[], metavar="FILE", help=help_)
    add("--references", type=Path, metavar="FILE", help="references of the custom groups' tasks")
    help_ = "write scorecards/NAME.json and boards.json to DIR, and remove other scorecards from it"
    add("--out", type=Path, metavar="DIR", help=help_)
    add("--jobs", type=int, metavar="N", help="worker processes (default: CPU count + 1)")
    add("--version", action="version", version=version("gym-extensions"))
    return command


def parse_args(argv: list[str] | None) -> argparse.Namespace:
    """The options of a command line; exits with status 2 where they are wrong."""
    command = parser()
    options = command.parse_args(argv)
    if not options.folders and not options.compare:
        command.error("name at least one FOLDER, or two with --compare")
    others = ("folders", "json", "csv", "out", "jobs")
    if options.compare and any(getattr(options, name) for name in others):
        command.error("--compare takes two submissions, only with --group, --groups and --references")
    if options.out and options.group:
        command.error("--out writes whole submissions: leave out --group")
    if options.jobs is not None and options.jobs < 1:
        command.error("--jobs takes a number from 1")
    return options


def print_text(text: str) -> None:
    """Writes text to standard output as UTF-8, whatever the locale is."""
    sys.stdout.flush()
    sys.stdout.buffer.write(text.encode())
    sys.stdout.buffer.flush()


def _compare(paths: list[Path], scorer: "Scorer") -> int:
    from gym_extensions.scoring.output import screen
    from gym_extensions.scoring.pipeline import find_submissions
    from gym_extensions.scoring.ranking.boards import compare

    cards = []
    for path in paths:
        folders = find_submissions(path)
        if len(folders) != 1:
            hint = "Name two submissions."
            raise BenchError("bad-compare", f"It contains {len(folders)} submissions.", str(path), hint)
        cards.append(scorer(folders[0]))
    out = screen.console()
    refused = [card for card in cards if card.problems]
    for card in refused:
        screen.show_line(out, card)
    if not refused:
        screen.show_comparison(out, cards[0].name, cards[1].name, compare(*cards))
    return int(bool(refused))


def _score(options: argparse.Namespace, scorer: "Scorer") -> int:
    from gym_extensions.scoring import pipeline
    from gym_extensions.scoring.output import screen

    folders = pipeline.find_submissions(options.folders)
    as_text = options.json or options.csv
    out = screen.console()
    texts = (f"scoring {folder.name} ({i} of {len(folders)})" for i, folder in enumerate(folders, 1))
    cards: Iterable[Scorecard] = screen.awaited(pipeline.scorecards(folders, scorer, options.jobs), texts)
    if options.out:
        cards = pipeline.publish(options.out, cards, scorer.references)
    if as_text:
        cards = list(cards)
        if options.json:
            print_text(pipeline.scorecard_document(cards, scorer.references).to_json())
        else:
            from gym_extensions.scoring.output import board_frames  # loads pandas

            print_text(board_frames.to_csv(board_frames.metrics_frame(cards)))
        return int(any(card.problems for card in cards))
    status = 0
    for card in cards:
        status |= bool(card.problems)
        if len(folders) > MAX_IN_FULL:
            screen.show_line(out, card)
        else:
            screen.show(out, card, bool(options.group))
    return status


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command and returns the exit status."""
    options = parse_args(argv)
    from gym_extensions.scoring.pipeline import make_scorer

    scorer = make_scorer(options.groups, options.references, options.group)
    try:
        return _compare(options.compare, scorer) if options.compare else _score(options, scorer)
    except BrokenPipeError:
        raise
    except OSError as error:
        message, path = f"{error.strerror or error}.", str(error.filename or "")
        raise BenchError("not-written", message, path, "Choose another folder for --out.") from error
