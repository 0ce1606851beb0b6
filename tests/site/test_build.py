"""The build is reproducible and atomic, and never overwrites a folder that is not a built site."""

from __future__ import annotations

import contextlib
import copy
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.site import build as module
from gym_extensions.site.output import MARK

from .browser import files, typed

OTHER_TIME_ZONE = "Asia/Tokyo" if time.timezone != -9 * 3600 else "UTC"


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below the folder by its path."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def build(document: dict[str, Any], out: Path) -> Path:
    """Builds the site that shows these JSON values."""
    return module.build(typed(document), out)


def test_two_builds_have_the_same_bytes(document: dict[str, Any], tmp_path: Path) -> None:
    build(copy.deepcopy(document), tmp_path / "first")
    build(document, tmp_path / "second")
    assert contents(tmp_path / "first") == contents(tmp_path / "second")


def test_the_order_of_submissions_in_the_document_changes_no_page(document: dict[str, Any]) -> None:
    pages = {path: text for path, text in files(document) if path.endswith(".html")}
    document["submissions"].reverse()
    assert {path: text for path, text in files(document) if path.endswith(".html")} == pages


def test_the_build_does_not_depend_on_hash_seed_time_zone_or_folder(
    document: dict[str, Any], tmp_path: Path
) -> None:
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
    with contextlib.chdir(tmp_path / "first"):
        build(document, tmp_path / "first" / "site")  # with this process's random hash seed
    source = tmp_path / "document.json"
    source.write_text(json.dumps(document), encoding="utf-8")
    program = (
        "import sys; from pathlib import Path; from gym_extensions.site.build import build;"
        "from gym_extensions.scoring.scorecard import ScorecardDocument;"
        "build(ScorecardDocument.from_json(Path(sys.argv[1]).read_bytes()), Path(sys.argv[2]))"
    )
    command = [sys.executable, "-c", program, str(source), str(tmp_path / "second" / "site")]
    setting = {"PYTHONHASHSEED": "2", "TZ": OTHER_TIME_ZONE, "LC_ALL": "C"}
    subprocess.run(command, check=True, cwd=tmp_path / "second", env={**os.environ, **setting})
    assert contents(tmp_path / "first" / "site") == contents(tmp_path / "second" / "site")


def test_no_page_contains_an_absolute_path(document: dict[str, Any], tmp_path: Path) -> None:
    build(document, tmp_path / "site")
    paths = [str(path).encode() for path in (tmp_path, Path.cwd(), Path.home())]
    for name, data in contents(tmp_path / "site").items():
        assert not [path for path in paths if path in data], name


def test_a_build_replaces_the_previous_one_completely(document: dict[str, Any], tmp_path: Path) -> None:
    build(document, tmp_path / "site")
    document["submissions"] = [row for row in document["submissions"] if row["name"] != "agile"]
    assert build(document, tmp_path / "site") == tmp_path / "site" / "index.html"
    assert not (tmp_path / "site" / "submissions" / "agile.html").exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["site"]


def test_a_failed_build_leaves_the_previous_one(
    document: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build(document, tmp_path / "site")
    before = contents(tmp_path / "site")

    def broken(site: module.Site, cards: Any) -> Any:
        yield "index.html", "half"
        raise RuntimeError("the disk is full")

    monkeypatch.setattr(module.Site, "files", broken)
    with pytest.raises(RuntimeError, match="the disk is full"):
        build(document, tmp_path / "site")
    assert contents(tmp_path / "site") == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["site"]


def test_a_folder_that_is_not_a_built_site_is_never_replaced(
    document: dict[str, Any], tmp_path: Path
) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work", encoding="utf-8")
    with pytest.raises(BenchError) as raised:
        build(document, tmp_path / "mine")
    assert str(raised.value) == (
        f"{tmp_path / 'mine'}: It exists and does not contain a built site. "
        "Name a new or empty folder with --out."
    )
    assert (tmp_path / "mine" / "thesis.tex").read_text(encoding="utf-8") == "years of work"


def test_a_file_is_never_replaced_by_a_folder(document: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "site").write_text("a file", encoding="utf-8")
    with pytest.raises(BenchError):
        build(document, tmp_path / "site")
    assert (tmp_path / "site").read_text(encoding="utf-8") == "a file"


def test_an_empty_folder_is_accepted(document: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "site").mkdir()
    build(document, tmp_path / "site")
    assert (tmp_path / "site" / MARK).is_file()


def test_two_submissions_with_the_same_name_are_refused(document: dict[str, Any]) -> None:
    document["submissions"].append(copy.deepcopy(document["submissions"][0]))
    with pytest.raises(BenchError) as raised:
        list(files(document))
    assert str(raised.value) == "Two submissions have the name 'agile'. Rename one of the folders."


def test_a_document_of_another_format_is_refused(document: dict[str, Any]) -> None:
    document["format"] = 2
    with pytest.raises(ValueError, match=r"Invalid enum value 2 - at `\$.format`"):
        list(files(document))


def test_a_site_without_submissions_says_how_to_add_one(document: dict[str, Any], tmp_path: Path) -> None:
    document["submissions"] = []
    index = build(document, tmp_path / "site")
    assert "There are no submissions yet." in index.read_text(encoding="utf-8")


def test_submissions_without_a_board_are_not_called_absent(document: dict[str, Any], tmp_path: Path) -> None:
    document["submissions"] = [row for row in document["submissions"] if row["name"] == "trial"]
    text = build(document, tmp_path / "site").read_text(encoding="utf-8")
    assert "No submission is on a board of sequential training yet." in text
    assert "There are no submissions yet." not in text
