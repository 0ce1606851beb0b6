"""``gym-extensions site``: scores submissions and builds the pages of the leaderboard."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from io import TextIOWrapper
from itertools import groupby
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from gym_extensions.errors import reports_mistakes, working
from gym_extensions.scoring.output.screen import count, show_line
from gym_extensions.scoring.pipeline import Scorer, find_submissions, references_info
from gym_extensions.scoring.records import RECORDS, verified_records
from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.board_views import BoardView
from gym_extensions.site.build import base_digest, build_site
from gym_extensions.site.output import folder_key, scorecards_since
from gym_extensions.site.play.mujoco_wasm import FOLDER, load
from gym_extensions.site.text import ends, mean

PIPE_WIDTH = 160
"""Columns of a table that is not printed on a terminal."""


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
    return options


def is_empty(folder: Path) -> bool:
    """Whether a folder has only hidden files and a README, so that no submission is meant."""
    try:
        names = [child.name for child in folder.iterdir()]
    except OSError:  # not a folder, or not readable: the scorer reports it
        return False
    return all(name.startswith(".") or name == "README.md" for name in names)


def chapter(board: BoardView) -> str:
    """The title of a board's table: protocol, budget, and whether agents observe the task."""
    return f"{board.protocol}, budget {board.budget}{', task-conditioned' if board.task_conditioned else ''}"


def table(title: str, boards: Sequence[BoardView]) -> Table:
    """A line per board: its first entry with score, interval and forgetting, and how many are ranked."""
    lines = Table(
        title=title, title_justify="left", box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0)
    )
    lines.add_column("Board", overflow="fold", min_width=22)
    lines.add_column("First entry", overflow="fold", min_width=12)
    for name in ("Score", "95 % interval", "Forgetting", "Ranked"):
        lines.add_column(name, justify="right", no_wrap=True)
    for board in boards:
        ranked = f"{board.ranked} of {len(board.rows)}"
        lines.add_row(*map(Text, (board.group, *_first(board), ranked)))
    return lines


def _first(board: BoardView) -> tuple[str, str, str, str]:
    leader = board.leader
    if leader is None:
        return ("no score yet", "–", "–", "–")
    row = leader.row
    forgetting = "nothing" if row.result.learned_nothing else mean(row.result.metric("forgetting"))
    return (row.entry.title, mean(row.score), ends(row.score), forgetting)


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Builds the site. Prints the boards, the problems of refused submissions and the path of the index."""
    options = parser().parse_args(argv)
    empty = [folder for folder in options.submissions if is_empty(folder)]
    folders = find_submissions([folder for folder in options.submissions if folder not in empty])
    references = load_references()
    info = references_info(references)
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
        )
    # Text from submissions is printed literally, and never stops the output in a narrow encoding.
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    width = None if sys.stdout.isatty() else PIPE_WIDTH
    console = Console(highlight=False, markup=False, emoji=False, width=width)
    for title, boards in groupby(built.leaderboard.boards, key=chapter):
        console.print(table(title, tuple(boards)))
        console.print()
    for folder in empty:
        print(f"{folder} contains no submissions.")
    if refused:
        console.print("Refused (not on a board until all problems are fixed):")
    for card in refused:
        show_line(console, card)
    print(built.index)
    return 1 if refused else 0
