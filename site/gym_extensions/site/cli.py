"""``gym-extensions site``: scores submissions and builds the leaderboard's pages."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from gym_extensions.catalog.errors import BenchError, reports_mistakes
from gym_extensions.scoring.scorecard import score_folders
from gym_extensions.site import words
from gym_extensions.site.build import build
from gym_extensions.site.page import Leaderboard


def arguments() -> argparse.ArgumentParser:
    """The command's options."""
    parser = argparse.ArgumentParser(
        prog="gym-extensions site",
        description="Score submissions and build the leaderboard's pages.",
        epilog="Exit status: 0 fine, 1 built, but a submission was refused (its page lists why), 2 usage.",
    )
    parser.add_argument(
        "submissions",
        nargs="*",
        type=Path,
        default=[Path("submissions")],
        help="submission folders, or folders of them (default: submissions/)",
    )
    parser.add_argument("--out", type=Path, default=Path("_site"), help="where the pages go (default: _site)")
    return parser


def table(leaderboard: Leaderboard) -> Table:
    """A line for each board: who leads, how sure that is, what was forgotten."""
    made = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    made.add_column("Board", overflow="fold")
    made.add_column("Leads")
    for name in ("Score", "95 % interval", "Forgetting", "Entries"):
        made.add_column(name, justify="right", no_wrap=name == "Score")
    for board in leaderboard.boards:
        lead = board.lead()
        if lead is None:
            cells = ["nobody has a value", "–", "–", "–"]
        else:
            row = lead[0]
            forgetting = row.trial.metric("forgetting")
            kept = "nothing learned" if row.trial.learned_nothing else words.value(forgetting)
            cells = [row.entry.title, words.value(row.lead), words.ends(row.lead), kept]
        made.add_row(*map(Text, (board.id, *cells, str(len(board.rows)))))
    return made


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Builds the site, prints where it is and a short table; 1 where a submission was refused."""
    chosen = arguments().parse_args(argv)
    missing = [path for path in chosen.submissions if not path.exists()]
    if missing:
        hint = "Name a submission's folder, or a folder of submissions."
        raise BenchError("no-such-folder", "There is no such folder.", where=str(missing[0]), hint=hint)
    document = score_folders(chosen.submissions)
    index = build(document, chosen.out)
    leaderboard = Leaderboard(document)
    console = Console(highlight=False)
    if leaderboard.boards:
        console.print(table(leaderboard))
    refused = [entry for entry in leaderboard.entries if entry.problems]
    for entry in refused:
        count = words.count(len(entry.problems), "problem")
        console.print(Text(f"refused: {entry.name} ({count}; `score` lists them, and so does its page)"))
    print(index)
    return 1 if refused else 0
