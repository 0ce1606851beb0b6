"""Entries of one author and family of algorithms are counted on their rows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.leaderboard.related import family
from gym_extensions.scoring.pipeline.score import score_folders

from ...conftest import MANIFEST


@pytest.mark.parametrize(
    ("algorithm", "expected"),
    [
        ("trpo", "trpo"),
        ("TRPO-2017", "trpo"),
        ("sac_fresh_buffer", "sac"),
        (" ppo (ours)", "ppo"),
        ("τ", "τ"),
    ],
)
def test_the_family_is_the_beginning_of_the_name(algorithm: str, expected: str) -> None:
    assert family(algorithm) == expected


def test_a_row_names_the_other_entries_of_its_author_and_family(
    tmp_path: Path, submission: Callable[..., Path]
) -> None:
    for name, author, algorithm in [
        ("a", "A. Author", "trpo"),
        ("b", "a.  author", "TRPO-2"),
        ("c", "A. Author", "sac"),
        ("d", "B. Author", "trpo"),
    ]:
        manifest = MANIFEST.replace('"smoke"', '"100k"').replace("A. Nonymous", author)
        manifest = manifest.replace('algorithm = "formula"', f'algorithm = "{algorithm}"')
        submission(name=name, protocols=("single",), runs=(0,), manifest=manifest)
    (board,) = boards(score_folders([tmp_path]).submissions).boards
    assert {row.name: row.related for row in board.rows} == {"a": ("b",), "b": ("a",), "c": (), "d": ()}
