"""The ``score`` command: checks, scores and prints submissions."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from gym_extensions.errors import BenchError, reports_mistakes

FEW = 3
"""So many submissions are shown whole; of more, a line each, and their problems."""


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    made = argparse.ArgumentParser(
        prog="score",
        description="Checks submissions, scores them and prints their scorecards.",
        epilog="Exit status: 0 everything is fine, 1 a submission has problems, 2 the command was misused.",
    )
    made.add_argument(
        "folders", nargs="*", type=Path, metavar="FOLDER", help="a submission, or a folder of submissions"
    )
    form = made.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print the scorecards as JSON (docs/scorecard.md)")
    form.add_argument("--csv", action="store_true", help="print every metric as a row of CSV")
    form.add_argument("--markdown", action="store_true", help="print tables in Markdown")
    made.add_argument(
        "--compare", nargs=2, type=Path, metavar=("A", "B"), help="compare two submissions, metric by metric"
    )
    made.add_argument(
        "--verify", action="store_true", help="also replay the recorded episodes in the simulator"
    )
    made.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="write scorecards/<name>.json and boards.json here; older scorecards are removed",
    )
    made.add_argument(
        "--cache", type=Path, metavar="DIR", help="keep scorecards here and score only what has changed"
    )
    made.add_argument(
        "--jobs", type=int, metavar="N", help="worker processes (default: one a core, and one more)"
    )
    return made


def asked(argv: list[str] | None) -> argparse.Namespace:
    """The options of a command line; ends the program where they contradict each other."""
    made = parser()
    options = made.parse_args(argv)
    if not options.folders and not options.compare:
        made.error("name at least one FOLDER, or two with --compare")
    alone = ("folders", "csv", "markdown", "out", "cache", "verify", "jobs")
    if options.compare and any(getattr(options, name) for name in alone):
        made.error("--compare takes two submissions, and of the other options --json alone")
    if options.jobs is not None and options.jobs < 1:
        made.error("--jobs takes a number from 1")
    return options


def _print(text: str) -> None:
    """Writes text to standard output as UTF-8, whatever the locale says."""
    sys.stdout.flush()
    sys.stdout.buffer.write(text.encode())
    sys.stdout.buffer.flush()


def _compare(pair: list[Path], as_json: bool) -> int:
    from gym_extensions.rollouts.folder import submission_folders
    from gym_extensions.scoring.leaderboard.compare import compare
    from gym_extensions.scoring.output import summary as screens
    from gym_extensions.scoring.output.console import console
    from gym_extensions.scoring.pipeline.score import score_folder, text

    scored = []
    for path in pair:
        found = submission_folders([path])
        if len(found) != 1:
            hint = "Name two submissions."
            raise BenchError("bad-compare", f"It holds {len(found)} submissions.", str(path), hint)
        scored.append(score_folder(found[0]))
    broken = [card for card in scored if card["problems"]]
    for card in broken:
        screens.show_line(console(errors=as_json), card)
    if broken:
        return 1
    compared = compare(*scored)
    if as_json:
        _print(text(compared))
    else:
        screens.show_comparison(console(), compared)
    return 0


def _verified(path: Path, card: dict[str, Any]) -> dict[str, Any]:
    if card["problems"] or card["trust"] == "reported":
        return card
    from gym_extensions.scoring.replay.verify import verified

    found: dict[str, Any] = verified({"submissions": [card]}, [path])["submissions"][0]
    return found


def _score(options: argparse.Namespace) -> int:
    from gym_extensions.rollouts.folder import submission_folders
    from gym_extensions.scoring.output import summary as screens
    from gym_extensions.scoring.output.console import console
    from gym_extensions.scoring.output.tables import csv_text, markdown_text
    from gym_extensions.scoring.pipeline.batch import Work, cards
    from gym_extensions.scoring.pipeline.publish import Publisher
    from gym_extensions.scoring.pipeline.score import document, text
    from gym_extensions.scoring.references import load_references

    references = load_references()
    folders = submission_folders(options.folders)
    printed = next((form for form in ("json", "csv", "markdown") if getattr(options, form)), "")
    out, kept, problems = console(), [], False
    published = Publisher(options.out, references) if options.out else None
    known = document([], references)["references"]
    work = Work(references, options.cache)
    for path, scored in zip(folders, cards(folders, work, options.jobs), strict=True):
        card = _verified(path, scored) if options.verify else scored
        problems = problems or bool(card["problems"])
        try:
            if printed:
                kept.append(card)
            elif len(folders) > FEW:
                screens.show_line(out, card)
            else:
                screens.show(out, card, known)
        except BrokenPipeError:
            if not published:
                raise
            _nobody_reads()
        if published:
            published.add(card)
    if published:
        published.finish(options.jobs)
    if printed:
        forms = {"json": text, "csv": csv_text, "markdown": markdown_text}
        _print(forms[printed](document(kept, references)))
    return 1 if problems else 0


def _nobody_reads() -> None:
    """Lets everything that is still printed go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command; gives the exit status."""
    options = asked(argv)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        return _compare(options.compare, options.json) if options.compare else _score(options)
    except BrokenPipeError:
        _nobody_reads()
        return 1
    except OSError as error:
        place = str(error.filename or "")
        raise BenchError(
            "not-written", f"{error.strerror or error}.", place, "Choose another place."
        ) from error
