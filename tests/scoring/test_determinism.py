"""The same folder gives the same bytes: on any locale, time zone, umask, hash seed, order, workers."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.rollouts.folder import submission_folders
from gym_extensions.scoring.pipeline.batch import Work, cards
from gym_extensions.scoring.pipeline.score import document, score_folders, text
from gym_extensions.scoring.references import References

Write = Callable[..., Path]

MANY = {"runs": (0, 1, 2), "curves": 12, "protocols": ("sequential", "single", "joint")}


@pytest.fixture
def many(submission: Write) -> Path:
    """A folder of three submissions, one of them broken."""
    for name in ("b", "a", "c"):
        folder = submission(name=f"all/{name}", **MANY)
    (folder / "notes.txt").write_text("")
    return folder.parent


def _out(folder: Path, out: Path, umask: int = 0o022, **environment: str) -> dict[str, bytes]:
    code = (
        f"import os, sys; os.umask({umask}); from gym_extensions.scoring.cli import main; "
        "print(main(sys.argv[1:]), file=sys.stderr)"
    )
    subprocess.run(
        [sys.executable, "-c", code, str(folder), "--out", str(out)],
        env={**os.environ, **environment},
        check=True,
        capture_output=True,
    )
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in sorted(out.rglob("*.json"))}


def test_two_environments_write_the_same_bytes(many: Path, tmp_path: Path) -> None:
    first = _out(many, tmp_path / "A", LC_ALL="C", TZ="UTC", PYTHONHASHSEED="0")
    second = _out(
        many,
        tmp_path / "B",
        umask=0o077,
        LC_ALL="de_DE.UTF-8",
        TZ="Asia/Kathmandu",
        PYTHONHASHSEED="12345",
        COLUMNS="40",
        OPENBLAS_NUM_THREADS="2",
    )
    assert len(first) == 4
    assert first == second


def test_the_place_and_the_order_of_folders_do_not_matter(many: Path, references: References) -> None:
    folders = submission_folders([many])
    whole = text(score_folders(folders, references))
    assert text(score_folders(folders[::-1], references)) == whole
    assert text(score_folders([many], references)) == whole
    moved = many.rename(many.with_name("elsewhere"))
    assert text(score_folders([moved], references)) == whole
    assert str(moved.parent) not in whole


def test_workers_do_not_matter(many: Path, references: References) -> None:
    folders = submission_folders([many])
    one, two = (
        text(document(list(cards(folders, Work(references), workers)), references)) for workers in (1, 2)
    )
    assert one == two


def test_a_change_of_one_digit_changes_the_bytes(many: Path, references: References) -> None:
    before = text(score_folders([many], references))
    log = many / "a" / "hopper-gravity" / "single.csv"
    content = log.read_text()
    log.write_text(content.replace("110.5,", "110.6,", 1))
    assert log.read_text() != content
    assert text(score_folders([many], references)) != before
