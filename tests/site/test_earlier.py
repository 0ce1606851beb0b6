"""A second build scores only the submissions that changed, and writes the bytes of a new build."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.__main__ import main
from gym_extensions.catalog.groups import group
from gym_extensions.curation.digest import folder_digest
from gym_extensions.curation.ledger.chain import FILE
from gym_extensions.scoring.pipeline.score import Scorer
from gym_extensions.scoring.references import Reference, References
from gym_extensions.scoring.repetition.record import FOLDER, RepetitionRecord, write
from gym_extensions.site import build as module
from gym_extensions.site import cli
from gym_extensions.site.earlier import kept_path

from ..curation.ledger.test_chain import LINE, chain
from .test_cli import submission

Scored = list[str]
TASKS = {task: Reference(0.0, 100.0, unsolved=False) for task in group("hopper-gravity").task_ids}
REFERENCES = References("made-up", True, TASKS, "0f" * 32)


@pytest.fixture
def scored(monkeypatch: pytest.MonkeyPatch) -> Scored:
    """The names of the submissions that are scored, in their order."""
    names: Scored = []
    call = Scorer.__call__

    def noted(scorer: Scorer, path: Path) -> object:
        names.append(path.name)
        return call(scorer, path)

    monkeypatch.setattr(Scorer, "__call__", noted)
    return names


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the site of two submissions and their ledger."""
    root = tmp_path_factory.mktemp("original")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        patch.setattr(cli, "load_references", lambda: REFERENCES)
        for name in ("alpha", "beta"):
            submission(root / "submissions", name)
        (root / "submissions" / FILE).touch()
        assert main(["site"]) == 0
    return root


@pytest.fixture
def built(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory of a test, with a copy of that folder."""
    shutil.copytree(original, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli, "load_references", lambda: REFERENCES)
    return tmp_path


def pages(site: Path) -> dict[str, bytes]:
    """Every file of a site by path."""
    return {str(path.relative_to(site)): path.read_bytes() for path in site.rglob("*") if path.is_file()}


def test_without_a_change_nothing_is_scored_and_the_bytes_are_those_of_a_new_build(
    built: Path, scored: Scored
) -> None:
    assert main(["site"]) == 0
    assert scored == []
    assert main(["site", "--out", "new"]) == 0
    assert scored == ["alpha", "beta"]
    assert pages(built / "_site") == pages(built / "new")


def test_a_changed_and_a_new_submission_are_scored_and_a_removed_one_disappears(
    built: Path, scored: Scored
) -> None:
    submission(built / "submissions", "alpha", runs=3)
    submission(built / "submissions", "gamma")
    shutil.rmtree(built / "submissions" / "beta")
    assert main(["site"]) == 0
    assert scored == ["alpha", "gamma"]
    assert main(["site", "--out", "new"]) == 0
    assert pages(built / "_site") == pages(built / "new")


def test_what_the_ledger_says_later_is_shown_without_scoring_again(built: Path, scored: Scored) -> None:
    line = replace(LINE, entry="alpha", digest=folder_digest(built / "submissions" / "alpha"))
    (built / "submissions" / FILE).write_bytes(chain(line))
    assert main(["site"]) == 0
    assert scored == []
    assert main(["site", "--out", "new"]) == 0
    assert pages(built / "_site") == pages(built / "new")
    entry = json.loads((built / "_site/api/entries/alpha.json").read_text(encoding="utf-8"))
    assert entry["submissions"][0]["ledger"]["reason"] == LINE.reason


def test_the_record_of_a_repetition_changes_what_is_missing(built: Path, scored: Scored) -> None:
    record = write(built / FOLDER, RepetitionRecord(submission="alpha"))
    for _ in range(2):
        assert main(["site"]) == 0
    record.unlink()
    assert main(["site"]) == 0
    assert scored == ["alpha", "alpha"]


@pytest.mark.parametrize("replayed", [LINE.episodes, LINE.replayed])
def test_whether_all_episodes_were_replayed_changes_what_is_missing(
    built: Path, scored: Scored, replayed: int
) -> None:
    digest = folder_digest(built / "submissions" / "alpha")
    line = replace(LINE, entry="alpha", digest=digest, replayed=replayed)
    (built / "submissions" / FILE).write_bytes(chain(line))
    assert main(["site"]) == 0
    assert scored == ["alpha"] * (replayed == LINE.episodes)
    assert main(["site"]) == 0
    assert scored == ["alpha"] * (replayed == LINE.episodes)


@pytest.mark.parametrize("item", ["link", "folder"])
def test_an_item_that_no_digest_contains_is_noticed(built: Path, scored: Scored, item: str) -> None:
    path = built / "submissions" / "alpha" / "hopper-gravity" / "added"
    path.mkdir() if item == "folder" else path.symlink_to("sequential.csv")
    main(["site"])
    assert scored == ["alpha"]


@pytest.mark.parametrize("content", [b"", b"\x93", b"[]"])
def test_a_damaged_scorecard_is_made_again(built: Path, scored: Scored, content: bytes) -> None:
    (built / "_site" / kept_path("beta")).write_bytes(content)
    assert main(["site"]) == 0
    assert scored == ["beta"]


def test_other_code_scores_everything(built: Path, scored: Scored, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "source_digest", lambda: "another")
    assert main(["site"]) == 0
    assert scored == ["alpha", "beta"]


def test_other_references_score_everything(
    built: Path, scored: Scored, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed = replace(REFERENCES, version="another")
    monkeypatch.setattr(cli, "load_references", lambda: changed)
    assert main(["site"]) == 0
    assert scored == ["alpha", "beta"]


def test_a_build_that_replays_scores_everything(
    built: Path, scored: Scored, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gym_extensions.scoring.replay import verify as replay

    monkeypatch.setattr(replay, "verify", lambda *_: replay.Verification(1, 1, ()))
    for _ in range(2):
        assert main(["site", "--verify"]) == 0
        assert scored == ["alpha", "beta"]
        scored.clear()
    assert main(["site"]) == 0
    assert scored == ["alpha", "beta"]


def test_without_a_ledger_everything_is_scored(built: Path, scored: Scored) -> None:
    (built / "submissions" / FILE).unlink()
    for _ in range(2):
        assert main(["site"]) == 0
        scored.clear()
    assert main(["site"]) == 0
    assert scored == ["alpha", "beta"]
