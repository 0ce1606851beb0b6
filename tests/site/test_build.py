"""The build is reproducible and atomic, and never overwrites a folder that is not a built site."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.build import Site, build_site
from gym_extensions.site.pages import PAGES
from gym_extensions.site.pages.page import Render

from ..conftest import refused
from .browser import files, references_of, typed
from .conftest import build, contents, everything

OTHER_TIME_ZONE = "Asia/Tokyo" if time.timezone != -9 * 3600 else "UTC"


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A built site."""
    folder = tmp_path_factory.mktemp("built") / "site"
    with contextlib.chdir(folder.parent):
        build(everything(), folder)  # with this process's random hash seed
    return folder


@pytest.fixture
def site(original: Path, tmp_path: Path) -> Path:
    """A copy of it, alone in its folder."""
    return shutil.copytree(original, tmp_path / "site")


def test_the_build_does_not_depend_on_hash_seed_time_zone_or_folder(original: Path, tmp_path: Path) -> None:
    source = tmp_path / "document.json"
    source.write_text(json.dumps(everything()), encoding="utf-8")
    program = (
        "import sys; from pathlib import Path; from gym_extensions.site.build import build_site;"
        "from gym_extensions.site.pages import PAGES; from gym_extensions.site.pages.page import Render;"
        "from gym_extensions.references import References;"
        "from gym_extensions.scoring.scorecard import ScorecardDocument;"
        "from gym_extensions.scoring.submission.scorer import completed;"
        "whole = ScorecardDocument.from_json(Path(sys.argv[1]).read_bytes()); named = whole.references;"
        "cards, known = map(completed, whole.submissions), References(named.version, {}, named.sha256);"
        "build_site(cards, Render(known, PAGES), Path(sys.argv[2]))"
    )
    command = [sys.executable, "-c", program, str(source), str(tmp_path / "site")]
    setting = {"PYTHONHASHSEED": "2", "TZ": OTHER_TIME_ZONE, "LC_ALL": "C"}
    subprocess.run(command, check=True, cwd=tmp_path, env={**os.environ, **setting})
    assert contents(original) == contents(tmp_path / "site")


def test_a_build_replaces_the_whole_folder_and_removes_what_a_killed_build_left(
    original: Path, site: Path
) -> None:
    (site / "submissions" / "agile.html").write_text("edited", encoding="utf-8")
    (site / "old.html").write_text("old", encoding="utf-8")
    (site.parent / ".site-new-0").mkdir()
    build(everything(), site)
    assert contents(site) == contents(original)
    assert [path.name for path in site.parent.iterdir()] == ["site"]
    assert not [path for path in contents(site) if path.startswith(".")]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_failed_or_interrupted_build_leaves_the_previous_one(
    original: Path, site: Path, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    def broken(_site: Site, _cards: Any) -> Any:
        yield "index.html", "half"
        raise error

    monkeypatch.setattr(Site, "files", broken)
    with pytest.raises(error):
        build(everything(), site)
    assert contents(site) == contents(original)
    assert [path.name for path in site.parent.iterdir()] == ["site"]


def test_a_build_that_cannot_take_the_place_of_the_previous_one_leaves_it(
    original: Path, site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rename = Path.rename

    def refused(source: Path, target: Path) -> Path:
        if source.name == "new":
            raise OSError("busy")
        return rename(source, target)

    monkeypatch.setattr(Site, "files", lambda *_: iter([("index.html", "new")]))
    monkeypatch.setattr(Path, "rename", refused)
    with pytest.raises(BenchError, match=r"site: busy\. Name a new or empty folder"):
        build(everything(), site)
    assert contents(site) == contents(original)


def test_a_folder_has_one_build_at_a_time(original: Path, tmp_path: Path) -> None:
    whole, out = typed(everything()), tmp_path / "site"

    def cards() -> Iterator[Scorecard]:
        yield whole.submissions[0]
        with pytest.raises(BenchError, match=r"site: Another process builds it\. Wait"):
            build(everything(), out)
        yield from whole.submissions[1:]

    build_site(cards(), Render(references_of(whole), PAGES), out)
    assert contents(out) == contents(original)


@pytest.mark.parametrize("name", ["notes.txt", "index.html", ".git"])
def test_a_folder_that_is_not_a_built_site_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine", encoding="utf-8")
    for out in (tmp_path, tmp_path / name):
        with pytest.raises(BenchError, match=r"does not contain a built site\. Name a new or empty folder"):
            build(everything(), out)
    assert contents(tmp_path) == {name: b"mine"}


def test_two_submissions_with_the_same_name_are_refused(document: dict[str, Any]) -> None:
    document["submissions"].append(document["submissions"][0])
    with refused("same-name", "Two submissions have the name 'agile'"):
        list(files(document))
