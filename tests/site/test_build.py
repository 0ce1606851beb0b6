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
from gym_extensions.site.build import Site

from .browser import files
from .conftest import build, contents

OTHER_TIME_ZONE = "Asia/Tokyo" if time.timezone != -9 * 3600 else "UTC"


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
        "import sys; from pathlib import Path; from gym_extensions.site.build import build_site;"
        "from gym_extensions.scoring.scorecard import ScorecardDocument;"
        "whole = ScorecardDocument.from_json(Path(sys.argv[1]).read_bytes());"
        "build_site(whole.submissions, whole.references, Path(sys.argv[2]))"
    )
    command = [sys.executable, "-c", program, str(source), str(tmp_path / "second" / "site")]
    setting = {"PYTHONHASHSEED": "2", "TZ": OTHER_TIME_ZONE, "LC_ALL": "C"}
    subprocess.run(command, check=True, cwd=tmp_path / "second", env={**os.environ, **setting})
    assert contents(tmp_path / "first" / "site") == contents(tmp_path / "second" / "site")


def test_a_failed_build_leaves_the_previous_one(
    document: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build(document, tmp_path / "site")
    before = contents(tmp_path / "site")

    def broken(site: Site, cards: Any) -> Any:
        yield "index.html", "half"
        raise RuntimeError("the disk is full")

    monkeypatch.setattr(Site, "files", broken)
    with pytest.raises(RuntimeError, match="the disk is full"):
        build(document, tmp_path / "site")
    assert contents(tmp_path / "site") == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["site"]


def test_two_submissions_with_the_same_name_are_refused(document: dict[str, Any]) -> None:
    document["submissions"].append(copy.deepcopy(document["submissions"][0]))
    with pytest.raises(BenchError) as raised:
        list(files(document))
    assert str(raised.value) == "Two submissions have the name 'agile'. Rename one of the folders."
