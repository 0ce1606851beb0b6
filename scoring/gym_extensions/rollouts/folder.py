"""Lists a submission's folder with names, kinds and sizes, without following links or opening files."""

from __future__ import annotations

import functools
import os
import unicodedata
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import (
    MANIFEST,
    MAX_CSV_BYTES,
    MAX_DEPTH,
    MAX_FILES,
    MAX_SUBMISSION_BYTES,
    PROGRESS,
    max_bytes,
)
from gym_extensions.rollouts.problem import escape
from gym_extensions.rollouts.regular_file import read_regular

ROOT = "."
"""The path of the submission's folder itself, listed only if it cannot be read."""


@dataclass(frozen=True)
class FolderItem:
    """A file or folder, with its path inside the submission (with ``/``), its kind, and its size in bytes.

    The kind is ``file``, ``folder``, or one that a submission may not contain: ``link``, ``device``,
    ``unreadable`` (a folder) or ``unreadable file``.
    """

    path: str
    kind: str
    size: int = 0


@dataclass(frozen=True)
class FolderSize:
    """The number of files, the bytes of all of them, and the bytes of the CSV files."""

    files: int
    total: int
    csv: int

    @property
    def is_within_limits(self) -> bool:
        """Whether the files are few and small enough to be read."""
        return self.files <= MAX_FILES and self.total <= MAX_SUBMISSION_BYTES and self.csv <= MAX_CSV_BYTES


@dataclass(frozen=True)
class Folder:
    """A submission's folder, its content sorted by path, and the groups that it may contain by name."""

    root: Path
    name: str
    items: tuple[FolderItem, ...]
    groups: Mapping[str, TaskGroup] = field(default_factory=lambda: GROUPS)

    @functools.cached_property
    def files(self) -> dict[str, FolderItem]:
        """The regular files by path."""
        return {item.path: item for item in self.items if item.kind == "file"}

    @functools.cached_property
    def size(self) -> FolderSize:
        """The size of the regular files."""
        sizes = [(path, item.size) for path, item in self.files.items()]
        csv = sum(size for path, size in sizes if path.endswith(".csv"))
        return FolderSize(len(sizes), sum(size for _, size in sizes), csv)

    def read(self, path: str) -> bytes:
        """The bytes of a file.

        Raises:
            OSError: the file cannot be read, or has become a link, another kind of file, or larger than its
                limit since the folder was listed.
        """
        return read_regular(self.root, path, max_bytes(path))


def _items(folder: Path, prefix: str, depth: int) -> Iterator[FolderItem]:
    try:
        children = list(os.scandir(folder))
    except OSError:
        yield FolderItem(prefix.rstrip("/") or ROOT, "unreadable")
        return
    for child in children:
        path = f"{prefix}{escape(child.name)}"
        if path == PROGRESS:
            continue
        if child.is_symlink():
            yield FolderItem(path, "link")
        elif child.is_dir(follow_symlinks=False):
            yield FolderItem(path, "folder")
            if depth < MAX_DEPTH:
                yield from _items(Path(child.path), f"{path}/", depth + 1)
        elif child.is_file(follow_symlinks=False):
            try:
                yield FolderItem(path, "file", child.stat(follow_symlinks=False).st_size)
            except OSError:
                yield FolderItem(path, "unreadable file")
        else:
            yield FolderItem(path, "device")


def exists_readable(path: Path, kind: Callable[[Path], bool] = Path.exists) -> bool:
    """``kind(path)``, or False where permission is denied."""
    try:
        return kind(path)
    except OSError:
        return False


def scan(root: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> Folder:
    """The folder as it is on disk; without items if the path is not a folder."""
    name = escape(root.name or root.resolve().name)
    if not exists_readable(root, Path.is_dir):
        return Folder(root, name, (), groups)
    items = tuple(sorted(_items(root, "", 1), key=lambda item: item.path))
    return Folder(root, name, items, groups)


def _candidates(path: Path) -> list[Path]:
    """The visible folders in a folder, and links without a target."""
    try:
        children = sorted(child for child in path.iterdir() if not child.name.startswith("."))
    except OSError:
        return []
    return [child for child in children if exists_readable(child, Path.is_dir) or _is_broken_link(child)]


def _is_broken_link(path: Path) -> bool:
    return exists_readable(path, Path.is_symlink) and not exists_readable(path)


def submission_folders(paths: list[Path]) -> list[Path]:
    """The submissions at the given paths, sorted by name. A folder of submissions means all of them.

    Raises:
        BenchError: two submissions have the same name.
    """
    folders: list[Path] = []
    for path in paths:
        is_alias = exists_readable(path, Path.is_symlink) or path.name in ("", ".", "..")
        target = path.resolve() if is_alias else path
        candidates = [] if exists_readable(target / MANIFEST) else _candidates(target)
        has_submissions = any(exists_readable(candidate / MANIFEST) for candidate in candidates)
        folders += candidates if has_submissions else [target]
    by_name: dict[str, Path] = {}
    for folder in folders:
        first = by_name.setdefault(unicodedata.normalize("NFKC", folder.name).casefold(), folder)
        if first.absolute() != folder.absolute():
            same = first.name == folder.name
            names = f"the name {escape(folder.name)!r}" if same else "names that differ only in letter case"
            message = f"Two submissions have {names}: {first} and {folder}."
            raise BenchError("two-of-one-name", escape(message), hint="Score one at a time, or rename one.")
    return sorted(by_name.values(), key=lambda folder: folder.name)
