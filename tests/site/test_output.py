"""A build writes what changed, keeps what did not, and notices files that were edited by hand."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.site import build as module
from gym_extensions.site.build import Built, Renderer, build_site
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.output import MARK, Output, digest, encoded
from gym_extensions.site.page import Draft
from gym_extensions.site.pages import boards
from gym_extensions.site.views.entrant import entrant

from .browser import typed
from .conftest import everything


def build(document: dict[str, Any], out: Path) -> Built:
    """Builds the site that shows these JSON values."""
    whole = typed(document)
    return build_site(whole.submissions, whole.references, out)


def inodes(folder: Path) -> dict[str, int]:
    """The file behind each path: a kept file is the same one."""
    return {str(path.relative_to(folder)): path.stat().st_ino for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, int], dict[str, int]]:
    """The files of a site before and after the entry Keeper, on two boards, gets another title."""
    out = tmp_path_factory.mktemp("site") / "site"
    document = everything()
    build(document, out)
    before = inodes(out)
    document["submissions"][1]["title"] = "Renamed"
    build(document, out)
    return before, inodes(out)


def test_a_page_of_another_entry_or_board_is_kept(changed: tuple[dict[str, int], dict[str, int]]) -> None:
    before, after = changed
    for path in (
        "submissions/agile.html",
        "api/entries/agile.json",
        "boards/hopper-gravity-v0-single-100k.html",
        "boards/hopper-gravity-v0-sequential-100k-task-conditioned.html",
    ):
        assert after[path] == before[path], path


def test_the_pages_of_a_changed_entry_and_of_its_boards_are_written(
    changed: tuple[dict[str, int], dict[str, int]],
) -> None:
    before, after = changed
    for path in (
        "submissions/keeper.html",
        "api/entries/keeper.json",
        "boards/hopper-gravity-v0-sequential-100k.html",
        "boards/walker2d-gravity-v0-sequential-100k.html",
    ):
        assert after[path] != before[path], path


def test_a_page_of_a_board_is_written_again_when_another_page_changes_the_scale() -> None:
    document = everything()
    row = document["submissions"][1]
    row["groups"] = {name: row["groups"][name] for name in ("hopper-gravity-v0",)}
    row["suites"] = {}
    document["submissions"] = [row | {"name": f"entry-{at:02d}"} for at in range(51)]
    before = second_page(document)
    first = copy.deepcopy(document["submissions"][0])
    value = first["groups"]["hopper-gravity-v0"]["sequential"]["metrics"]["final_performance"]
    value["runs"] = [*value["runs"][:-1], 9.0]
    document["submissions"][0] = first
    assert second_page(document) != before


def second_page(document: dict[str, Any]) -> bytes:
    """The inputs of the second page of the board that these entries are on."""
    whole = typed(document)
    cards = tuple(entrant(card, digest(encoded(card)).encode()) for card in whole.submissions)
    site = Leaderboard(whole.references, cards)
    path = "boards/hopper-gravity-v0-sequential-100k-2.html"
    content = dict(boards.publish(site, Renderer(site, ())))[path]
    assert isinstance(content, Draft)
    return content.inputs


def test_a_build_without_a_change_writes_no_file_but_its_mark(tmp_path: Path) -> None:
    document, out = everything(), tmp_path / "site"
    build(document, out)
    before = inodes(out)
    build(document, out)
    after = inodes(out)
    assert [path for path in after if after[path] != before[path]] == [MARK]


def test_a_changed_build_equals_a_new_one(tmp_path: Path) -> None:
    document = everything()
    build(document, tmp_path / "site")
    document["submissions"][1]["title"] = "Renamed"
    build(document, tmp_path / "site")
    build(document, tmp_path / "new")
    for path in inodes(tmp_path / "new"):
        assert (tmp_path / "site" / path).read_bytes() == (tmp_path / "new" / path).read_bytes(), path


def test_other_code_writes_every_page_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build(everything(), tmp_path / "site")
    before = inodes(tmp_path / "site")
    monkeypatch.setattr(module, "source_digest", lambda: "another")
    build(everything(), tmp_path / "site")
    assert inodes(tmp_path / "site")["submissions/agile.html"] != before["submissions/agile.html"]


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
