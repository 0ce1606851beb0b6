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

from gym_extensions.curation.ledger.apply import with_ledgers
from gym_extensions.curation.ledger.chain import FILE
from gym_extensions.errors import reports_mistakes
from gym_extensions.scoring.output.summary import show_line
from gym_extensions.scoring.pipeline.score import Scorer, find_submissions, references_info, scorecards
from gym_extensions.scoring.poses.files import FOLDER as POSES
from gym_extensions.scoring.reevaluation.record import FOLDER as REEVALUATIONS
from gym_extensions.scoring.reevaluation.record import load, with_record
from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.build import base_digest, build_site
from gym_extensions.site.earlier import EarlierSite
from gym_extensions.site.text.labels import ends, mean
from gym_extensions.site.views.board import Board


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
    options.add_argument("--out", type=Path, default=Path("_site"), help="output folder (default: _site)")
    options.add_argument(
        "--poses", type=Path, default=POSES, help="poses of `gym-extensions watch` (default: %(default)s)"
    )
    options.add_argument(
        "--reevaluations",
        type=Path,
        default=REEVALUATIONS,
        help="records of `gym-extensions reevaluate` (default: %(default)s)",
    )
    options.add_argument("--verify", action="store_true", help="also replay the recorded episodes (slow)")
    return options


def is_empty(folder: Path) -> bool:
    """Whether a folder has only hidden files, a README and a ledger, so that no submission is meant."""
    try:
        names = [child.name for child in folder.iterdir()]
    except OSError:  # not a folder, or not readable: the scorer reports it
        return False
    return all(name.startswith(".") or name in ("README.md", FILE) for name in names)


def chapter(board: Board) -> str:
    """The title of a board's table: protocol, budget, and whether agents observe the task."""
    return f"{board.protocol}, budget {board.budget}{', task-conditioned' if board.task_conditioned else ''}"


def table(title: str, boards: Sequence[Board]) -> Table:
    """A line per board: its first entry with score, interval and forgetting, and how many are ranked."""
    lines = Table(
        title=title, title_justify="left", box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0)
    )
    lines.add_column("Board", no_wrap=True, min_width=22)
    lines.add_column("First entry", overflow="fold", min_width=12)
    for name in ("Score", "95 % interval", "Forgetting", "Ranked"):
        lines.add_column(name, justify="right", no_wrap=True)
    for board in boards:
        ranked = f"{board.ranked} of {len(board.rows)}"
        lines.add_row(*map(Text, (board.group, *_first(board), ranked)))
    return lines


def _first(board: Board) -> tuple[str, str, str, str]:
    leader = board.leader
    if leader is None:
        return ("no score yet", "–", "–", "–")
    row = leader.row
    forgetting = "nothing" if row.trial.learned_nothing else mean(row.trial.metric("forgetting"))
    return (row.entry.title, mean(row.score), ends(row.score), forgetting)


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Builds the site. Prints the boards, the problems of refused submissions and the path of the index."""
    options = parser().parse_args(argv)
    empty = [folder for folder in options.submissions if is_empty(folder)]
    folders = find_submissions([folder for folder in options.submissions if folder not in empty])
    references = load_references()
    info = references_info(references)
    base = base_digest(info, "verified" if options.verify else "")
    earlier = EarlierSite(options.out, base)
    refused, pending = [], []

    def scored() -> Iterator[Scorecard]:
        scorer = Scorer(references)
        cards = (
            scorecards(folders, scorer, verify=True)
            if options.verify
            else earlier.scorecards(folders, scorer)
        )
        for card in with_ledgers(cards, folders, earlier.folder_digest):
            if card.problems:
                refused.append(card)
            if card.ledger and card.ledger.is_pending:
                pending.append(card.name)
            yield with_record(card, load(options.reevaluations, card.name))

    keys = {folder.name: earlier.key(folder) for folder in folders}
    built = build_site(scored(), info, options.out, options.poses, base, keys=keys)
    # Text from submissions is printed literally, and never stops the output in a narrow encoding.
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    console = Console(highlight=False, markup=False, emoji=False)
    for title, boards in groupby(built.leaderboard.boards, key=chapter):
        console.print(table(title, tuple(boards)))
        console.print()
    for folder in empty:
        print(f"{folder} contains no submissions.")
    if pending:
        console.print(f"Not accepted yet, so without a rank (docs/ledger.md): {', '.join(pending)}")
    if refused:
        console.print("Refused (not on a board until all problems are fixed):")
    for card in refused:
        show_line(console, card)
    print(built.index)
    return 1 if refused else 0
