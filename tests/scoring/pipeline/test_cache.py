"""The cache: an unchanged folder is not scored again, and nothing doubtful is believed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.scoring.output.tables import csv_text, markdown_text
from gym_extensions.scoring.pipeline import batch
from gym_extensions.scoring.pipeline import cache as cache_module
from gym_extensions.scoring.pipeline.score import score_folders
from gym_extensions.scoring.references import References

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


def test_a_scorecard_from_the_cache_is_printed_as_it_was(
    submission: Write, references: References, tmp_path: Path
) -> None:
    groups, protocols = ("hopper-gravity", "halfcheetah-gravity"), ("sequential", "single", "joint")
    folders, cache = [submission(groups=groups, protocols=protocols)], tmp_path / "cache"
    first, again = (score_folders(folders, references, cache) for _ in range(2))
    assert csv_text(again) == csv_text(first)
    assert markdown_text(again) == markdown_text(first)


@pytest.mark.parametrize("place", ["a-file", "a-file/below"])
def test_a_cache_that_cannot_be_written_is_told_and_is_no_fault_of_a_submission(
    submission: Write, references: References, tmp_path: Path, place: str
) -> None:
    (tmp_path / "a-file").write_text("")
    cache = tmp_path / place
    with pytest.raises(BenchError) as told:
        score_folders([submission()], references, cache)
    assert (told.value.code, told.value.where) == ("not-written", str(cache / "entry.json"))
    assert str(told.value).endswith(". Choose another folder for --cache, or leave it out.")


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
        lambda text: "[" * 200_000,
        lambda text: text.replace('"notes":[]', '"notes":NaN'),
    ],
    ids=[
        "half written",
        "empty",
        "another document",
        "a changed card",
        "an old key",
        "no card",
        "no digest",
        "too deep",
        "no number",
    ],
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


def test_a_link_to_a_submission_is_not_the_submission(
    submission: Write, references: References, tmp_path: Path
) -> None:
    folder, work = submission(), batch.Work(references, tmp_path / "cache")
    assert work(folder)["problems"] == []
    elsewhere = folder.rename(tmp_path / "elsewhere")
    folder.symlink_to(elsewhere)
    assert [problem["rule"] for problem in work(folder)["problems"]] == ["not-a-regular-file"]


def test_a_file_beyond_the_limit_is_not_read(
    submission: Write, references: References, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = submission()
    with (folder / "hopper-gravity" / "joint.csv").open("wb") as file:
        file.truncate(2**40)
    rules = {
        one["rule"]
        for one in score_folders([folder], references, tmp_path / "cache")["submissions"][0]["problems"]
    }
    assert "too-large" in rules


def test_the_key_covers_the_papers_tables_and_not_where_the_code_lies(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    root = tmp_path / "references" / "scoring"
    (root / "references").mkdir(parents=True)
    (root / "__init__.py").write_text("")
    module = ModuleType("copy")
    module.__file__ = str(root / "__init__.py")
    monkeypatch.setattr(cache_module, "scoring", module)

    def digest(path: str, text: str) -> str:
        (root / path).write_text(text)
        return cache_module.code_digest.__wrapped__()

    texts = [
        ("metrics.py", "1"),
        ("metrics.py", "2"),
        ("references/paper.csv", "1"),
        ("references/paper.csv", "2"),
    ]
    digests = [digest(*text) for text in texts]
    assert len(set(digests)) == len(texts)
    assert (
        digest("references/provisional.json", "{}") == digests[-1]
    )  # the references have a digest of their own


def test_a_folder_that_breaks_the_scorer_stops_no_other(
    submission: Write, references: References, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = batch.read

    def read(path: Path) -> Any:
        return real(path) if path.name != "b" else {}["unforeseen"]

    monkeypatch.setattr(batch, "read", read)
    found = score_folders([submission(name=name) for name in "abc"], references)["submissions"]
    assert [card["trust"] for card in found] == ["well-formed", None, "well-formed"]
    assert found[1]["problems"] == [
        {
            "rule": "fault-of-the-scorer",
            "where": "b",
            "message": "The scorer stopped with KeyError in test_cache.py, read.",
            "hint": "This is a mistake of gym-extensions, whatever the folder holds: please report it.",
        }
    ]
