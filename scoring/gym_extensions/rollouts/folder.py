"""Lists a submission's folder with names, kinds and sizes, without following links or opening files."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MANIFEST, MAX_DEPTH, PROGRESS
from gym_extensions.rollouts.problem import escape

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

    def read(self, path: str) -> bytes:
        """The bytes of a file. Raises OSError if it cannot be read."""
        return (self.root / path).read_bytes()


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
        first = by_name.setdefault(folder.name, folder)
        if first.absolute() != folder.absolute():
            message = f"Two submissions have the name {escape(folder.name)!r}: {first} and {folder}."
            raise BenchError("two-of-one-name", escape(message), hint="Score one at a time, or rename one.")
    return [folder for _, folder in sorted(by_name.items())]
