"""What lies in a submission's folder: names, kinds and sizes, without following a link or opening a file."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import DEEPEST, MANIFEST, PROGRESS
from gym_extensions.rollouts.problem import printable

HERE = "."
"""The path of the submission's own folder, where that cannot be read."""


@dataclass(frozen=True)
class Entry:
    """A name in the folder: its path inside the submission with ``/``, its kind, its size in bytes."""

    path: str
    kind: str
    size: int = 0


@dataclass(frozen=True)
class Folder:
    """A submission's folder and everything in it, sorted by path."""

    root: Path
    name: str
    entries: tuple[Entry, ...]

    def files(self) -> list[Entry]:
        """The regular files."""
        return [entry for entry in self.entries if entry.kind == "file"]

    def has(self, path: str) -> bool:
        """Whether a regular file of that path is there."""
        return any(entry.path == path and entry.kind == "file" for entry in self.entries)

    def size(self, path: str) -> int:
        """The bytes of the regular file of that path; 0 where there is none."""
        return next((entry.size for entry in self.entries if entry.path == path), 0)

    def read(self, path: str) -> bytes:
        """The bytes of a file; raises OSError where it cannot be read."""
        return (self.root / path).read_bytes()


def _entries(folder: Path, prefix: str, depth: int) -> Iterator[Entry]:
    try:
        found = list(os.scandir(folder))
    except OSError:
        yield Entry(prefix.rstrip("/") or HERE, "unreadable")
        return
    for item in found:
        path = f"{prefix}{printable(item.name)}"
        if path == PROGRESS:
            continue
        if item.is_symlink():
            yield Entry(path, "link")
        elif item.is_dir(follow_symlinks=False):
            yield Entry(path, "folder")
            if depth < DEEPEST:
                yield from _entries(Path(item.path), f"{path}/", depth + 1)
        elif item.is_file(follow_symlinks=False):
            try:
                yield Entry(path, "file", item.stat(follow_symlinks=False).st_size)
            except OSError:
                yield Entry(path, "shut")
        else:
            yield Entry(path, "device")


def seen(path: Path, kind: Callable[[Path], bool] = Path.exists) -> bool:
    """Whether a path is there, or is a folder (``Path.is_dir``) and so on, as far as one may look."""
    try:
        return kind(path)
    except OSError:
        return False


def scan(root: Path) -> Folder:
    """The folder as it is on disk; a path that is no folder gives one without entries."""
    name = printable(root.name or root.resolve().name)
    if not seen(root, Path.is_dir):
        return Folder(root, name, ())
    return Folder(root, name, tuple(sorted(_entries(root, "", 1), key=lambda entry: entry.path)))


def _inside(path: Path) -> list[Path]:
    """What stands in a folder in the place of submissions: folders, and links that lead nowhere."""
    try:
        children = [child for child in sorted(path.iterdir()) if not child.name.startswith(".")]
    except OSError:
        return []
    return [
        one for one in children if seen(one, Path.is_dir) or (seen(one, Path.is_symlink) and not seen(one))
    ]


def submission_folders(paths: list[Path]) -> list[Path]:
    """The submissions that the paths name, sorted by name: a folder of submissions stands for all in it.

    Raises:
        BenchError: two of them have one name.
    """
    found: list[Path] = []
    for given in paths:
        path = given.resolve() if seen(given, Path.is_symlink) or given.name in ("", ".", "..") else given
        folders = [] if seen(path / MANIFEST) else _inside(path)
        holds = any(seen(child / MANIFEST) for child in folders)
        found += folders if holds else [path]
    named: dict[str, Path] = {}
    for path in found:
        first = named.setdefault(path.name, path)
        if first.absolute() != path.absolute():
            told = f"Two submissions have the name {printable(path.name)!r}: {first} and {path}."
            raise BenchError("two-of-one-name", printable(told), hint="Score one at a time, or rename one.")
    return [path for _, path in sorted(named.items())]
