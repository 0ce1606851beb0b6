"""The digest of a submission covers every file but the traces and the recorder's folder."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from gym_extensions.rollouts.auditing.submission_digest import submission_digest


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for path, content in {"submission.toml": b"a", "g/single.csv": b"b", "g/policies/p.npz": b"c"}.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes(content)
    return tmp_path


def test_the_digest_by_hand(folder: Path) -> None:
    files = (("g/policies/p.npz", b"c"), ("g/single.csv", b"b"), ("submission.toml", b"a"))
    text = "".join(f"{path} {hashlib.sha256(content).hexdigest()}\n" for path, content in files)
    assert submission_digest(folder) == hashlib.sha256(text.encode()).hexdigest()


@pytest.mark.parametrize("path", ["g/traces/t.npz", "g/traces/salt.txt", ".progress/x"])
def test_traces_and_the_recorders_files_leave_it_as_it_is(folder: Path, path: str) -> None:
    before = submission_digest(folder)
    (folder / path).parent.mkdir(parents=True)
    (folder / path).write_bytes(b"new")
    assert submission_digest(folder) == before


@pytest.mark.parametrize("path", ["g/single.csv", "g/policies/q.npz", "README.md", "traces.txt"])
def test_any_other_file_changes_it(folder: Path, path: str) -> None:
    before = submission_digest(folder)
    (folder / path).write_bytes(b"new")
    assert submission_digest(folder) != before
