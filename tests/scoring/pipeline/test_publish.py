"""``score --out``: the files that it writes, those that it removes, and where it refuses to write."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.scoring import cli

Write = Callable[..., Path]


def test_out_writes_scorecards_and_boards(submission: Write, known: None, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert cli.main([str(submission(name="a")), str(submission(name="b")), "--out", str(out)]) == 0
    assert sorted(path.relative_to(out).as_posix() for path in out.rglob("*.json")) == [
        "boards.json",
        "scorecards/a.json",
        "scorecards/b.json",
    ]
    assert json.loads((out / "boards.json").read_text()) == {"format": 1, "boards": []}


def test_out_holds_nothing_older(submission: Write, known: None, tmp_path: Path) -> None:
    folders, out = [submission(name=name) for name in "ab"], tmp_path / "out"
    cli.main([*map(str, folders), "--out", str(out)])
    cli.main([str(folders[1]), "--out", str(out)])
    assert [path.name for path in (out / "scorecards").iterdir()] == ["b.json"]


def test_a_reader_who_leaves_does_not_keep_the_scorecards_from_being_written(
    submission: Write, tmp_path: Path
) -> None:
    folders = [submission(name=f"entry{number}") for number in range(5)]
    script = "import sys; from gym_extensions.scoring.cli import main; sys.exit(main(sys.argv[1:]))"
    out = tmp_path / "out"
    command = [sys.executable, "-c", script, *map(str, folders), "--jobs", "1", "--out", str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        running.stdout.close()
        assert running.stderr is not None
        assert running.stderr.read() == b""
    assert running.returncode == 0
    assert len(list((out / "scorecards").iterdir())) == 5
    assert (out / "boards.json").exists()


def test_out_removes_only_scorecards(submission: Write, known: None, tmp_path: Path) -> None:
    notes = tmp_path / "out" / "scorecards" / "notes.json"
    notes.parent.mkdir(parents=True)
    for text in ('"hi"', "hi", "{}"):
        notes.write_text(text)
        cli.main([str(submission(name="a")), "--out", str(tmp_path / "out")])
        assert notes.read_text() == text


def test_out_is_no_submission(submission: Write, known: None, capsys: pytest.CaptureFixture[str]) -> None:
    folder = submission(name="a")
    assert cli.main([str(folder), "--out", str(folder)]) == 2
    assert "The folder is a submission. Name another one." in capsys.readouterr().err
    assert not (folder / "boards.json").exists()
