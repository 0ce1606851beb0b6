"""The ``score`` command: checks, scores and prints submissions."""

from __future__ import annotations

import argparse
from pathlib import Path

from gym_extensions.catalog.errors import reports_mistakes


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    made = argparse.ArgumentParser(
        prog="score",
        description="Checks submissions, scores them and prints their scorecards.",
        epilog="Exit status: 0 everything is fine, 1 a submission has problems, 2 the command was misused.",
    )
    made.add_argument(
        "folders", nargs="+", type=Path, metavar="FOLDER", help="a submission, or a folder of submissions"
    )
    made.add_argument("--json", action="store_true", help="print the scorecards as JSON (docs/scorecard.md)")
    made.add_argument(
        "--verify", action="store_true", help="also replay the recorded episodes in the simulator"
    )
    made.add_argument("--out", type=Path, metavar="DIR", help="write scorecards/<name>.json into this folder")
    return made


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command; gives the exit status."""
    options = parser().parse_args(argv)
    from gym_extensions.scoring import terminal
    from gym_extensions.scoring.log import write_text
    from gym_extensions.scoring.scorecard import score_folders, text

    document = score_folders(options.folders)
    if options.verify:
        from gym_extensions.scoring.replay import verified

        document = verified(document, options.folders)
    if options.out:
        for card in document["submissions"]:
            write_text(
                options.out / "scorecards" / f"{card['name']}.json", text({**document, "submissions": [card]})
            )
    if options.json:
        print(text(document), end="")
    else:
        terminal.show(document)
    return 1 if any(card["problems"] for card in document["submissions"]) else 0
