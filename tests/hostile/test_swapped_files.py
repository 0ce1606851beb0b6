"""Files that are exchanged while a submission is read are not followed and are not waited for."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.regular_file import read_regular

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows opens no folder and has no FIFO")


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "entry" / "group").mkdir(parents=True)
    (tmp_path / "entry" / "group" / "single.csv").write_bytes(b"log\n")
    (tmp_path / "secret").write_bytes(b"secret\n")
    return tmp_path / "entry"


def to_link(root: Path) -> None:
    (root / "group" / "single.csv").unlink()
    (root / "group" / "single.csv").symlink_to(root.parent / "secret")


def to_fifo(root: Path) -> None:
    (root / "group" / "single.csv").unlink()
    os.mkfifo(root / "group" / "single.csv")


def to_folder(root: Path) -> None:
    (root / "group" / "single.csv").unlink()
    (root / "group" / "single.csv").mkdir()


def to_linked_folder(root: Path) -> None:
    shutil.move(root / "group", root.parent / "elsewhere")
    (root / "group").symlink_to(root.parent / "elsewhere")


def to_large_file(root: Path) -> None:
    os.truncate(root / "group" / "single.csv", 33 * 2**20)


def to_nothing(root: Path) -> None:
    (root / "group" / "single.csv").unlink()


@pytest.mark.parametrize("swap", [to_link, to_fifo, to_folder, to_linked_folder, to_large_file, to_nothing])
def test_a_file_that_was_exchanged_after_it_was_listed(root: Path, swap: Callable[[Path], None]) -> None:
    folder = scan(root)
    assert folder.read("group/single.csv") == b"log\n"
    swap(root)
    with pytest.raises(OSError):
        folder.read("group/single.csv")


def test_the_size_is_bounded_by_what_is_read(root: Path) -> None:
    assert read_regular(root, "group/single.csv", 4) == b"log\n"
    with pytest.raises(OSError, match="It has more than 3 bytes"):
        read_regular(root, "group/single.csv", 3)
