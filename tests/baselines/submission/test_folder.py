"""Folders that cannot become a submission are rejected before anything runs."""

from __future__ import annotations

import errno
import shutil
from pathlib import Path
from typing import Any, NoReturn

import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.submission.folder import prepare, validate
from gym_extensions.errors import BenchError

from ..conftest import digests


def training_error(out: Path) -> str:
    with pytest.raises(BenchError) as error:
        train("zero", "hopper-motor-noise", "single", "smoke", 7, out=out)
    return str(error.value)


@pytest.mark.parametrize("name", ["zero run", "-zero", ".zero", "zéro", "z" * 65, "zero,2"])
def test_a_name_that_a_submission_cannot_have_is_rejected(name: str, tmp_path: Path) -> None:
    assert training_error(tmp_path / name) == (
        f"{tmp_path / name}: {name!r} is not a valid submission name. "
        "Use at most 64 letters, digits, dots, dashes and underscores; start with a letter or digit."
    )
    assert not list(tmp_path.iterdir())


def test_a_file_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "afile"
    path.touch()
    assert training_error(path) == (
        f"{path}: A submission is a folder, and this is a file. Choose another --out."
    )


def test_a_folder_below_a_file_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "afile").touch()
    path = tmp_path / "afile/mine"
    message = training_error(path)
    assert message.startswith(f"{path}: The folder is not writable: ")
    assert message.endswith(". Choose another --out.")


@pytest.mark.parametrize("method", ["mkdir", "touch"])
def test_a_folder_that_is_not_writable_is_rejected(
    method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any, **__: Any) -> NoReturn:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, method, refuse)
    assert training_error(tmp_path / "out") == (
        f"{tmp_path / 'out'}: The folder is not writable: Read-only file system. Choose another --out."
    )


def test_the_folder_that_contains_submissions_is_rejected(random_submission: Path, tmp_path: Path) -> None:
    shutil.copytree(random_submission, tmp_path / "submissions/random")
    out = tmp_path / "submissions"
    assert training_error(out) == (
        f"{out}: Unexpected folder 'random': a submission contains only group folders. "
        f"Use a folder for this submission alone, such as {out / 'mine'}."
    )
    assert not (out / "submission.toml").exists()


def test_folders_of_groups_and_of_unfinished_runs_are_allowed(tmp_path: Path) -> None:
    for name in (".progress", "hopper-motor-noise"):
        (tmp_path / name).mkdir()
    validate(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".progress", "hopper-motor-noise"]


def test_logs_without_a_manifest_are_rejected(random_submission: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    shutil.copytree(random_submission, out)
    (out / "submission.toml").unlink()
    before = digests(out)
    assert training_error(out) == (
        f"{out}: The folder contains hopper-motor-noise/single.csv but no submission.toml. "
        "Restore submission.toml, or choose another --out."
    )
    assert digests(out) == before


def test_a_manifest_that_is_not_toml_is_rejected(random_submission: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    shutil.copytree(random_submission, out)
    (out / "submission.toml").write_text("title =\n")
    assert training_error(out) == (
        f"{out / 'submission.toml'}: The file is not valid TOML: Invalid value (at line 1, column 8). "
        "Correct the file, or choose another --out."
    )


def test_preparing_a_folder_leaves_an_empty_folder(tmp_path: Path) -> None:
    prepare(tmp_path / "new/mine")
    assert not list((tmp_path / "new/mine").iterdir())
