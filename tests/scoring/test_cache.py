"""The cache: an unchanged folder is not scored again, and nothing doubtful is believed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.scoring import batch
from gym_extensions.scoring.normalise import References
from gym_extensions.scoring.scorecard import score_folders

Write = Callable[..., Path]


@pytest.fixture
def scored(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the submissions that are really scored, one by one."""
    names: list[str] = []
    real = batch.score

    def count(submission: Any, references: References) -> Any:
        names.append(submission.name)
        return real(submission, references)

    monkeypatch.setattr(batch, "score", count)
    return names


def test_only_what_is_new_or_has_changed_is_scored(
    submission: Write, references: References, scored: list[str], tmp_path: Path
) -> None:
    folders, cache = [submission(name="a"), submission(name="b")], tmp_path / "cache"
    first = score_folders(folders, references, cache)
    assert scored == ["a", "b"]
    assert score_folders(folders, references, cache) == first
    assert scored == ["a", "b"]
    folders.append(submission(name="c"))
    assert score_folders(folders, references, cache)["submissions"][:2] == first["submissions"]
    assert scored == ["a", "b", "c"]
    submission(name="a", value=lambda p, r, s, j, e: 1.0 * s + r)
    assert score_folders(folders, references, cache)["submissions"][0] != first["submissions"][0]
    assert scored == ["a", "b", "c", "a"]


def test_other_references_score_anew(
    submission: Write, references: References, scored: list[str], tmp_path: Path
) -> None:
    folder, cache = submission(), tmp_path / "cache"
    score_folders([folder], references, cache)
    other = References("other", True, references.tasks, "1" * 64)
    score_folders([folder], other, cache)
    assert scored == ["entry", "entry"]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: text[: len(text) // 2],
        lambda text: "",
        lambda text: "[]",
        lambda text: text.replace('"trust":"well-formed"', '"trust":"replayed (all)"'),
        lambda text: text.replace('"key":"', '"key":"0'),
        lambda text: json.dumps({**json.loads(text), "card": None}),
        lambda text: json.dumps({"key": json.loads(text)["key"], "sha256": "", "card": {"name": "entry"}}),
    ],
    ids=["half written", "empty", "another document", "a changed card", "an old key", "no card", "no digest"],
)
def test_a_cache_that_is_wrong_old_or_half_written_is_made_anew(
    spoil: Callable[[str], str], submission: Write, references: References, scored: list[str], tmp_path: Path
) -> None:
    folder, cache = submission(), tmp_path / "cache"
    first = score_folders([folder], references, cache)
    place = cache / "entry.json"
    whole = place.read_text()
    assert spoil(whole) != whole
    place.write_text(spoil(whole))
    assert score_folders([folder], references, cache) == first
    assert scored == ["entry", "entry"]
    assert place.read_text() == whole


def test_problems_are_kept_too(
    submission: Write, references: References, scored: list[str], tmp_path: Path
) -> None:
    folder, cache = submission(), tmp_path / "cache"
    (folder / "notes.txt").write_text("")
    first = score_folders([folder], references, cache)
    assert first["submissions"][0]["problems"]
    assert score_folders([folder], references, cache) == first
    (folder / "notes.txt").unlink()
    assert score_folders([folder], references, cache)["submissions"][0]["problems"] == []
    assert scored == ["entry", "entry"]
