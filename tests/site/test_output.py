"""A build writes what changed, keeps what did not, and scores only submissions that changed."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from gym_extensions import references
from gym_extensions.__main__ import main
from gym_extensions.scoring.pipeline import Scorer
from gym_extensions.site import build as module
from gym_extensions.site.output import MARK, SCRATCH, Output, kept_path
from gym_extensions.submissions.review import Decision, Review, write_review

from .conftest import build, contents, everything
from .made_submissions import REFERENCES, make_submission


def inodes(folder: Path) -> dict[str, int]:
    """The file behind each path: a kept file is the same one."""
    return {str(path.relative_to(folder)): path.stat().st_ino for path in folder.rglob("*") if path.is_file()}


KEPT = (
    *("submissions/agile.html", "api/submissions/agile.json", "groups/pusher-v0.html"),
    "boards/hopper-gravity-v0-sequential-100k-task-conditioned.html",
)
WRITTEN = (
    *("submissions/keeper.html", "api/submissions/keeper.json", "groups/walker2d-gravity-v0.html"),
    "boards/hopper-gravity-v0-sequential-100k.html",
)


def test_the_pages_of_a_changed_submission_and_of_its_boards_are_written_and_others_kept(
    tmp_path: Path,
) -> None:
    document, out = everything(), tmp_path / "site"
    build(document, out)
    before = inodes(out)
    document["submissions"][1]["title"] = "Renamed"  # of the submission Keeper, on two boards
    build(document, out)
    after = inodes(out)
    assert [path for path in KEPT if after[path] != before[path]] == []
    assert [path for path in WRITTEN if after[path] == before[path]] == []
    build(document, tmp_path / "new")
    assert contents(out) == contents(tmp_path / "new")


def test_what_an_interrupted_first_build_left_is_removed(tmp_path: Path) -> None:
    (tmp_path / f"{SCRATCH}0").mkdir()
    build(everything(), tmp_path)
    assert not list(tmp_path.glob(f"{SCRATCH}*"))


def test_a_build_without_a_change_writes_no_file_but_its_mark(tmp_path: Path) -> None:
    document, out = everything(), tmp_path / "site"
    build(document, out)
    before = inodes(out)
    build(document, out)
    after = inodes(out)
    assert [path for path in after if after[path] != before[path]] == [MARK]


@pytest.mark.parametrize("damage", ["edited", "deleted"])
def test_a_file_that_was_edited_or_deleted_is_written_again(tmp_path: Path, damage: str) -> None:
    texts = iter(["first", "second"])
    for _ in range(2):
        with Output(tmp_path / "site", "base") as output:
            output.add_draft("page.html", b"inputs", lambda: next(texts))
        page = tmp_path / "site" / "page.html"
        if page.read_text(encoding="utf-8") == "first":
            page.unlink() if damage == "deleted" else page.write_text("edited", encoding="utf-8")
    assert page.read_text(encoding="utf-8") == "second"


@pytest.mark.parametrize("mark", ["", "[]", "{", '{"page.html": 1}', '{"page.html": ["a"]}'])
def test_a_mark_without_digests_keeps_nothing(tmp_path: Path, mark: str) -> None:
    out = tmp_path / "site"
    out.mkdir()
    (out / MARK).write_text(mark, encoding="utf-8")
    (out / "page.html").write_text("old", encoding="utf-8")
    with Output(out, "base") as output:
        output.add_draft("page.html", b"inputs", lambda: "new")
    assert (out / "page.html").read_text(encoding="utf-8") == "new"
    assert list(json.loads((out / MARK).read_text(encoding="utf-8"))) == ["page.html"]


Scored = list[str]


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
        patch.setattr(references, "load_references", lambda: REFERENCES)
        for name in ("alpha", "beta"):
            make_submission(root / "submissions", name)
        assert main(["site"]) == 0
    return root


@pytest.fixture
def built(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory of a test, with a copy of that folder."""
    shutil.copytree(original, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(references, "load_references", lambda: REFERENCES)
    return tmp_path


def test_without_a_change_nothing_is_scored_and_the_bytes_are_those_of_a_new_build(
    built: Path, scored: Scored
) -> None:
    assert main(["site"]) == 0
    assert scored == []
    assert main(["site", "--out", "new"]) == 0
    assert scored == ["alpha", "beta"]
    assert contents(built / "_site") == contents(built / "new")


def test_a_changed_and_a_new_submission_are_scored_and_a_removed_one_disappears(
    built: Path, scored: Scored
) -> None:
    make_submission(built / "submissions", "alpha", runs=3)
    make_submission(built / "submissions", "gamma")
    shutil.rmtree(built / "submissions" / "beta")
    assert main(["site"]) == 0
    assert scored == ["alpha", "gamma"]
    assert main(["site", "--out", "new"]) == 0
    assert contents(built / "_site") == contents(built / "new")


def test_a_review_that_is_written_later_is_shown(built: Path, scored: Scored) -> None:
    accepted = Decision(action="accepted", by="maintainer", date="2026-11-26", reason="Verified.")
    write_review(built / "submissions" / "alpha", Review(decisions=[accepted]))
    assert main(["site"]) == 0
    assert scored == ["alpha"]
    assert "Verified." in (built / "_site" / "submissions" / "alpha.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("content", [b"", b"\x93", b"[]"])
def test_a_damaged_scorecard_is_made_again(built: Path, scored: Scored, content: bytes) -> None:
    (built / "_site" / kept_path("beta")).write_bytes(content)
    assert main(["site"]) == 0
    assert scored == ["beta"]


def test_other_code_scores_everything(built: Path, scored: Scored, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "source_digest", lambda: "another")
    assert main(["site"]) == 0
    assert scored == ["alpha", "beta"]
