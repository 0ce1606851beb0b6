"""The same folder gives the same bytes: on any locale, time zone, umask, hash seed, order, workers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.rollouts.folder import submission_folders
from gym_extensions.scoring.pipeline.score import Scorer, score_folders, scorecard_document, scorecards
from gym_extensions.scoring.references import References

Write = Callable[..., Path]

PROTOCOLS = ("sequential", "single", "joint")


@pytest.fixture
def many(submission: Write) -> Path:
    """A folder of three submissions, one of them broken."""
    for name in ("b", "a", "c"):
        folder = submission(name=f"all/{name}", runs=(0, 1, 2), curves=12, protocols=PROTOCOLS)
    (folder / "notes.txt").write_text("")
    return folder.parent


def _out(folder: Path, out: Path, umask: int = 0o022, **environment: str) -> dict[str, bytes]:
    """What the command writes in a process with this umask, environment and the environment's locale."""
    code = (
        f"import locale, os, sys; os.umask({umask}); locale.setlocale(locale.LC_ALL, '');"
        "from gym_extensions.scoring.cli import main; main(sys.argv[1:]);"
        "print(locale.localeconv()['decimal_point'], file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder), "--out", str(out)],
        env={**os.environ, **environment},
        check=True,
        capture_output=True,
        text=True,
    )
    files = {path.relative_to(out).as_posix(): path.read_bytes() for path in sorted(out.rglob("*.json"))}
    return files | {"decimal point": done.stderr.strip().encode()}


@pytest.fixture
def german(tmp_path: Path) -> dict[str, str]:
    """An environment with a German locale, whose decimal point is a comma, compiled for this test."""
    compiler = shutil.which("localedef")
    if compiler is None:
        pytest.skip("localedef, which compiles a locale, is not installed")
    command = [compiler, "-i", "de_DE", "-f", "UTF-8", str(tmp_path / "locales" / "de_DE.UTF-8")]
    (tmp_path / "locales").mkdir()
    if subprocess.run(command, check=False, capture_output=True).returncode:
        pytest.skip("the sources of the German locale are not installed")
    return {"LOCPATH": str(tmp_path / "locales"), "LC_ALL": "de_DE.UTF-8"}


def test_two_environments_write_the_same_bytes(many: Path, tmp_path: Path, german: dict[str, str]) -> None:
    first = _out(many, tmp_path / "A", LC_ALL="C", TZ="UTC", PYTHONHASHSEED="0")
    second = _out(
        many,
        tmp_path / "B",
        umask=0o077,
        TZ="Asia/Kathmandu",
        PYTHONHASHSEED="12345",
        COLUMNS="40",
        OPENBLAS_NUM_THREADS="2",
        **german,
    )
    assert (first.pop("decimal point"), second.pop("decimal point")) == (b".", b",")
    assert len(first) == 4
    assert first == second


def test_the_path_and_the_order_of_folders_do_not_matter(many: Path, references: References) -> None:
    folders = submission_folders([many])
    whole = score_folders(folders, references).to_json()
    assert score_folders(folders[::-1], references).to_json() == whole
    assert score_folders([many], references).to_json() == whole
    moved = many.rename(many.with_name("elsewhere"))
    assert score_folders([moved], references).to_json() == whole
    assert str(moved.parent) not in whole


def test_workers_do_not_matter(many: Path, references: References) -> None:
    folders = submission_folders([many])
    one, two = (
        scorecard_document(list(scorecards(folders, Scorer(references), workers)), references).to_json()
        for workers in (1, 2)
    )
    assert one == two


def test_a_change_of_one_digit_changes_the_bytes(many: Path, references: References) -> None:
    before = score_folders([many], references).to_json()
    log = many / "a" / "hopper-gravity" / "single.csv"
    content = log.read_text()
    log.write_text(content.replace("110.5,", "110.6,", 1))
    assert log.read_text() != content
    assert score_folders([many], references).to_json() != before
