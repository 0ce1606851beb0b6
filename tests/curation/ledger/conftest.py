"""A repository whose ledger grew in three steps, which no test changes, and copies of it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gym_extensions.scoring.leaderboard.board import boards

from ..repositories import commit, make_repository, write_entry
from .commands import VALUE, cards, record

SCORED = "halfcheetah-gravity"
"""A group with references, so that its boards have scores."""


def board(folder: Path) -> str:
    return boards(list(cards(folder).values())).to_json()


@pytest.fixture(scope="session")
def history(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """A repository whose ledger grew in three steps, and the board after each of them."""
    folder = make_repository(tmp_path_factory.mktemp("history"))
    shown = []
    write_entry(folder / "submissions", "first", group=SCORED)
    write_entry(folder / "submissions", "second", bonus=5.0, group=SCORED)
    record(folder, "2026-01-01")
    commit(folder)
    shown.append(board(folder))
    write_entry(folder / "submissions", "first", bonus=20.0, group=SCORED)
    record(folder, "2026-01-02", "Recorded again.", "--value", VALUE)
    commit(folder)
    shown.append(board(folder))
    shutil.rmtree(folder / "submissions" / "second")
    record(folder, "2026-01-03", "Asked for by its author.")
    commit(folder)
    shown.append(board(folder))
    return folder, shown


@pytest.fixture
def repository(history: tuple[Path, list[str]], tmp_path: Path) -> Path:
    """A copy of that repository, to change."""
    return Path(shutil.copytree(history[0], tmp_path / "repository"))
