"""The ledger command on a test's repository, its error, and the scorecards that its ledger gives."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.curation.ledger.apply import with_ledgers
from gym_extensions.curation.ledger.cli import main
from gym_extensions.scoring.pipeline.score import find_submissions, score_folders
from gym_extensions.scoring.scorecard.model import Scorecard

VALUE = "d" * 40


def ledger(folder: Path, *arguments: str) -> int:
    """The status with which the ledger command ends."""
    return main(["--submissions", str(folder / "submissions"), *arguments])


def record(folder: Path, date: str, reason: str = "A reason.", *options: str) -> None:
    """Records the state of the submissions on that date."""
    assert ledger(folder, "record", "--reason", reason, "--date", date, *options) == 0


def cards(folder: Path) -> dict[str, Scorecard]:
    """The scorecards of all submissions by name, with what the ledger says of them."""
    paths = [folder / "submissions"]
    scored = with_ledgers(score_folders(paths).submissions, find_submissions(paths))
    return {card.name: card for card in scored}


def problem(capsys: pytest.CaptureFixture[str], folder: Path, *arguments: str) -> str:
    """The error of a command that exits with status 2."""
    capsys.readouterr()
    assert ledger(folder, *arguments) == 2
    return capsys.readouterr().err
