"""``gym-extensions site``: scores submissions and builds the leaderboard's pages."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from io import TextIOWrapper
from itertools import groupby
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from gym_extensions.errors import reports_mistakes
from gym_extensions.scoring.output.summary import show_line
from gym_extensions.scoring.pipeline.score import score_folders
from gym_extensions.site.build import build
from gym_extensions.site.page import Leaderboard
from gym_extensions.site.text import labels as words
from gym_extensions.site.views.board import Board


def arguments() -> argparse.ArgumentParser:
    """The command's options."""
    parser = argparse.ArgumentParser(
        prog="gym-extensions site",
        description="Score submissions and build the leaderboard's pages.",
        epilog="Exit status: 0 fine, 1 built, but a submission was refused (it says why), 2 usage.",
    )
    parser.add_argument(
        "submissions",
        nargs="*",
        type=Path,
        default=[Path("submissions")],
        help="submission folders, or folders of them (default: submissions/)",
    )
    parser.add_argument("--out", type=Path, default=Path("_site"), help="where the pages go (default: _site)")
    parser.add_argument("--verify", action="store_true", help="also replay the recorded episodes (slow)")
    return parser


def chapter(board: Board) -> str:
    """What a board's table is headed by: protocol, budget, and whether agents observe the task."""
    return f"{board.protocol}, budget {board.budget}{', task-conditioned' if board.task_conditioned else ''}"


def table(title: str, boards: Sequence[Board]) -> Table:
    """A line for each board: who leads, how sure that is, what was forgotten, how many entries."""
    made = Table(
        title=title, title_justify="left", box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0)
    )
    made.add_column("Board", no_wrap=True, min_width=22)
    made.add_column("Leads", overflow="fold", min_width=12)
    for name in ("Score", "95 % interval", "Forgot", "Entries"):
        made.add_column(name, justify="right", no_wrap=True)
    for board in boards:
        made.add_row(*map(Text, (board.group, *_lead(board), str(len(board.rows)))))
    return made


def _lead(board: Board) -> tuple[str, str, str, str]:
    lead = board.lead()
    if lead is None:
        return ("nobody has a value", "–", "–", "–")
    row = lead[0]
    forgotten = "nothing" if row.trial.learned_nothing else words.value(row.trial.metric("forgetting"))
    return (row.entry.title, words.value(row.lead), words.ends(row.lead), forgotten)


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Builds the site; prints the boards, all problems of what is refused (exit status 1), and the place."""
    chosen = arguments().parse_args(argv)
    document = score_folders(chosen.submissions, verify=chosen.verify)
    index = build(document, chosen.out)
    leaderboard = Leaderboard(document)
    # What strangers wrote is printed literally, and never stops the output in a narrow encoding.
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    console = Console(highlight=False, markup=False, emoji=False)
    for title, boards in groupby(leaderboard.boards, key=chapter):
        console.print(table(title, tuple(boards)))
        console.print()
    refused = [card for card in document.submissions if card.problems]
    if refused:
        console.print("Refused, and on no board until every problem is gone:")
    for card in refused:
        show_line(console, card)
    print(index)
    return 1 if refused else 0
