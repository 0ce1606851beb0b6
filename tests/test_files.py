"""Atomic writes: nothing is left of a write that fails, and concurrent writes do not disturb each other."""

import errno
from pathlib import Path

import pytest

from gym_extensions.files import write_bytes


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
