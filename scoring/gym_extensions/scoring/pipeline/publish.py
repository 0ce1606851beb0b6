"""What ``score --out`` writes: a scorecard a submission as it is scored, and in the end the boards."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gym_extensions.atomic import write_text
from gym_extensions.rollouts.layout import NAME
from gym_extensions.scoring.leaderboard.keys import slim
from gym_extensions.scoring.pipeline.batch import boards_text
from gym_extensions.scoring.pipeline.score import document, text
from gym_extensions.scoring.references import References

Document = dict[str, Any]


class Publisher:
    """Writes ``scorecards/<name>.json`` and ``boards.json`` into a folder, which then holds nothing older.

    A submission whose name cannot be a file's (it has a problem that says so) gets no scorecard.
    """

    def __init__(self, folder: Path, references: References) -> None:
        self.folder = folder
        self.references = references
        self.slims: list[Document] = []

    def add(self, card: Document) -> None:
        """Writes one scorecard, and keeps of it what the boards need."""
        if NAME.fullmatch(card["name"]):
            place = self.folder / "scorecards" / f"{card['name']}.json"
            write_text(place, text(document([card], self.references)))
        self.slims.append(slim(card))

    def finish(self, workers: int | None = None) -> None:
        """Writes the boards, and removes the scorecards of entries that are gone."""
        names = {card["name"] for card in self.slims}
        for path in (self.folder / "scorecards").glob("*.json"):
            if path.stem not in names:
                path.unlink()
        write_text(self.folder / "boards.json", boards_text(self.slims, workers))
