"""Folders that cannot become a submission are refused before anything is run."""

from __future__ import annotations

import errno
import shutil
from pathlib import Path

import pytest

from gym_extensions.baselines.submission.folder import NAME, refuse_unfit
from gym_extensions.baselines.train import train
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.rules import folder as files

from ..conftest import digests


def told(out: Path, agent: str = "still") -> str:
    with pytest.raises(BenchError) as mistake:
        train(agent, "hopper-gravity", "single", "smoke", 7, out=out)
    return str(mistake.value)


@pytest.mark.parametrize("name", ["still run", "-still", ".still", "stíll", "s" * 65, "still,2"])
def test_a_name_that_the_checks_refuse_is_refused_first(name, tmp_path):
    assert told(tmp_path / name) == (
        f"{tmp_path / name}: {name!r} is no name of a submission. "
        "Begin with a letter or digit; then letters, digits, dots, dashes, underscores, 64 in all."
    )
    assert not list(tmp_path.iterdir())


def test_the_names_are_those_that_the_checks_let_through():
    assert NAME.pattern == files.NAME.pattern


def test_a_file_is_no_folder_of_a_submission(tmp_path):
    (tmp_path / "afile").touch()
    assert told(tmp_path / "afile") == (
        f"{tmp_path / 'afile'}: This is a file, and a submission is a folder. Choose another --out."
    )


def test_a_folder_below_a_file_is_none_either(tmp_path):
    (tmp_path / "afile").touch()
    assert told(tmp_path / "afile/mine") == (
        f"{tmp_path / 'afile/mine'}: Nothing can be written here: Not a directory. Choose another --out."
    )


@pytest.mark.parametrize("method", ["mkdir", "touch"])
def test_a_place_where_nothing_can_be_written_is_told(method, tmp_path, monkeypatch):
    def refused(*_, **__):
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, method, refused)
    assert told(tmp_path / "out") == (
        f"{tmp_path / 'out'}: Nothing can be written here: Read-only file system. Choose another --out."
    )


def test_the_folder_above_submissions_is_none_itself(random_submission, tmp_path):
    shutil.copytree(random_submission, tmp_path / "submissions/random")
    out = tmp_path / "submissions"
    assert told(out) == (
        f"{out}: It holds the folder 'random', which is no group, so it is no submission. "
        f"Name a folder of the submission's own, as in {out / 'mine'}."
    )
    assert not (out / "submission.toml").exists()


def test_groups_and_what_unfinished_runs_keep_are_a_submissions_own(tmp_path):
    for name in (".progress", "hopper-gravity"):
        (tmp_path / name).mkdir()
    refuse_unfit(tmp_path)


def test_logs_without_a_manifest_are_nobodys(random_submission, tmp_path):
    out = tmp_path / "mine"
    shutil.copytree(random_submission, out)
    (out / "submission.toml").unlink()
    before = digests(out)
    assert told(out) == (
        f"{out}: hopper-gravity/single.csv is here, and no submission.toml says whose it is. "
        "Put its submission.toml back, or choose another --out."
    )
    assert digests(out) == before


def test_a_broken_manifest_is_not_to_be_removed(random_submission, tmp_path):
    out = tmp_path / "mine"
    shutil.copytree(random_submission, out)
    (out / "submission.toml").write_text("title =\n")
    assert told(out) == (
        f"{out / 'submission.toml'}: This is no TOML: Invalid value (at line 1, column 8). "
        "Correct that place, or choose another --out."
    )


def test_preparing_a_folder_leaves_nothing_but_the_folder(tmp_path):
    from gym_extensions.baselines.submission.folder import prepare

    prepare(tmp_path / "new/mine")
    assert not list((tmp_path / "new/mine").iterdir())
