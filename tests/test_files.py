"""Atomic writes: nothing is left of a write that fails, and concurrent writes do not disturb each other."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from gym_extensions.files import replace_folder, write_bytes


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_write_that_stops_leaves_the_file_as_it_was_and_no_other(
    error: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, write = tmp_path / "log.csv", Path.write_bytes
    write_bytes(path, b"before")

    def stop(partial: Path, content: bytes) -> int:
        write(partial, content[:2])
        raise error

    monkeypatch.setattr(Path, "write_bytes", stop)
    with pytest.raises(type(error)):
        write_bytes(path, b"after")
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


def test_two_processes_can_write_a_file_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, write = tmp_path / "settings.json", Path.write_bytes

    def write_elsewhere(partial: Path, content: bytes) -> int:
        written = write(partial, content)
        with monkeypatch.context() as other_process:
            other_process.setattr(Path, "write_bytes", write)
            write_bytes(path, content)
        return written

    monkeypatch.setattr(Path, "write_bytes", write_elsewhere)
    write_bytes(path, b"content")
    assert path.read_bytes() == b"content"
    assert list(tmp_path.iterdir()) == [path]


def names(folder: Path) -> list[str]:
    """Everything below a folder."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def test_a_folder_takes_the_place_of_another(tmp_path: Path) -> None:
    target, new = tmp_path / "target", tmp_path / "new"
    write_bytes(target / "before", b"")
    write_bytes(new / "after", b"")
    replace_folder(target, new)
    assert names(tmp_path) == ["target", "target/after"]


def test_a_folder_that_cannot_be_replaced_stays(tmp_path: Path) -> None:
    write_bytes(tmp_path / "target" / "before", b"")
    with pytest.raises(FileNotFoundError):
        replace_folder(tmp_path / "target", tmp_path / "missing")
    assert names(tmp_path) == ["target", "target/before"]
