"""``gym-extensions site``: scores submissions and builds the pages of the leaderboard."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from io import TextIOWrapper
from itertools import groupby
from pathlib import Path

from rich.table import Table
from rich.text import Text

from gym_extensions.errors import reports_mistakes, working
from gym_extensions.scoring.output.screen import console, count, plain_table, show_line
from gym_extensions.scoring.pipeline import Scorer, find_submissions
from gym_extensions.scoring.records import RECORDS, verified_records
from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.scorecard import ReferencesInfo, Scorecard
from gym_extensions.site.board_views import BoardView
from gym_extensions.site.build import base_digest, build_site
from gym_extensions.site.output import folder_key, scorecards_since
from gym_extensions.site.play.mujoco_wasm import FOLDER, load
from gym_extensions.site.text import ends, mean

WIDTH = 120
"""Columns of output that is not printed on a terminal."""


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    options = argparse.ArgumentParser(
        prog="gym-extensions site",
        description="Score submissions and build the pages of the leaderboard.",
        epilog="Exit status: 0 success, 1 built but at least one submission was refused, 2 usage error.",
    )
    options.add_argument(
        "submissions",
        nargs="*",
        type=Path,
        default=[Path("submissions")],
        help="submission folders, or folders that contain them (default: submissions/)",
    )
    options.add_argument(
        "--records",
        type=Path,
        default=Path(RECORDS),
        metavar="DIR",
        help="folder of records (default: records/)",
    )
    options.add_argument("--out", type=Path, default=Path("_site"), help="output folder (default: _site)")
    options.add_argument(
        "--mujoco",
        type=Path,
        default=FOLDER,
        metavar="FOLDER",
        help=f"MuJoCo for the page Play, as `make site-assets` fetches it (default: {FOLDER}, if it exists)",
    )
    options.add_argument(
        "--docs",
        action="store_true",
        help="link to the documentation, which `make docsite` builds into OUT/docs",
    )
    return options


def is_empty(folder: Path) -> bool:
    """Whether a folder has only hidden files and a README, so that no submission is meant."""
    try:
        names = [child.name for child in folder.iterdir()]
    except OSError:  # not a folder, or not readable: the scorer reports it
        return False
    return all(name.startswith(".") or name == "README.md" for name in names)


def table(boards: Iterable[BoardView]) -> Table:
    """A line per board: its first entry with score, interval and forgetting, and how many are ranked."""
    lines = plain_table("board", "score", "95 % interval", "forgetting", "ranked", "first entry")
    for board in boards:
        facts, entry = ("–", "–", "–"), "no score yet"
        if board.leader is not None:
            row = board.leader.row
            forgetting = "nothing" if row.result.learned_nothing else mean(row.result.metric("forgetting"))
            facts, entry = (mean(row.score), ends(row.score), forgetting), row.entry.title
        lines.add_row(*map(Text, (board.group, *facts, f"{board.ranked} of {len(board.rows)}", entry)))
    return lines


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Builds the site. Prints the boards, the problems of refused submissions and the path of the index."""
    options = parser().parse_args(argv)
    empty = [folder for folder in options.submissions if is_empty(folder)]
    folders = find_submissions([folder for folder in options.submissions if folder not in empty])
    references = load_references()
    info = ReferencesInfo(references.version, references.digest)
    base = base_digest(info)
    keys = {folder.name: folder_key(folder, base) for folder in folders}
    scored = scorecards_since(options.out, folders, keys, Scorer(references))
    refused: list[Scorecard] = []

    def cards() -> Iterator[Scorecard]:
        for card in scored:
            if card.problems:
                refused.append(card)
            yield card

    with working(f"building the pages of {count(len(folders), 'submission')}"):
        built = build_site(
            cards(),
            info,
            options.out,
            base,
            keys=keys,
            folders={folder.name: folder for folder in folders},
            records=verified_records(options.records),
            simulator=load(options.mujoco),
            docs=options.docs,
        )
    if isinstance(sys.stdout, TextIOWrapper):  # a narrow encoding never stops the output
        sys.stdout.reconfigure(errors="backslashreplace")
    out = console()
    if not out.is_terminal:
        out.width = WIDTH
    for (protocol, budget, conditioned), boards in groupby(
        built.leaderboard.boards, key=lambda board: (board.protocol, board.budget, board.task_conditioned)
    ):
        out.print(f"{protocol}, budget {budget}{', task-conditioned' if conditioned else ''}", style="bold")
        out.print(table(boards))
        out.print()
    for folder in empty:
        print(f"{folder} contains no submissions.")
    if refused:
        out.print("Refused (not on a board until all problems are fixed):")
    for card in refused:
        show_line(out, card)
    print(built.index)
    return 1 if refused else 0
