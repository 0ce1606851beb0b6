"""What the ``score`` command can be asked for."""

from __future__ import annotations

import argparse
from pathlib import Path


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
