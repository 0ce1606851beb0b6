"""Writes the files of ``score --out``. Scorecards are written as they are scored, boards at the end."""

from __future__ import annotations

import json
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MANIFEST, NAME
from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.leaderboard.keys import strip_for_boards
from gym_extensions.scoring.pipeline.score import scorecard_document
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard.model import Scorecard


class Publisher:
    """Writes ``scorecards/<name>.json`` and ``boards.json`` into a folder and removes older scorecards.

    A submission whose name cannot be a file's name (a problem says so) gets no scorecard file.

    Raises:
        BenchError: the folder is a submission, to which no files may be added.
    """

    def __init__(self, folder: Path, references: References) -> None:
        if (folder / MANIFEST).exists():
            raise BenchError("bad-out", "The folder is a submission.", str(folder), "Name another one.")
        self.folder = folder
        self.references = references
        self.cards: list[Scorecard] = []

    def add(self, card: Scorecard) -> None:
        """Writes one scorecard and remembers the part that boards need."""
        if NAME.fullmatch(card.name):
            path = self.folder / "scorecards" / f"{card.name}.json"
            write_text(path, scorecard_document([card], self.references).to_json())
        self.cards.append(strip_for_boards(card))

    def finish(self) -> None:
        """Writes the boards and removes the scorecards of submissions that were not added."""
        names = {card.name for card in self.cards}
        for path in (self.folder / "scorecards").glob("*.json"):
            if path.stem not in names and _is_scorecard(path):
                path.unlink()
        write_text(self.folder / "boards.json", boards(self.cards).to_json())


def _is_scorecard(path: Path) -> bool:
    try:
        content = json.loads(path.read_bytes())
    except ValueError:
        return False
    return isinstance(content, dict) and {"references", "submissions"} <= content.keys()
