"""The folder of a submission: names, limits, and a listing that follows no links."""

import errno
import functools
import os
import re
import stat
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError
from gym_extensions.submissions.problem import escape

MANIFEST = "submission.toml"
README = "README.md"
"""An optional text about the submission, which the page of the submission shows as plain text."""
REVIEW = "review.toml"
"""What the base branch found out about the submission. A submitter never writes it."""
POSES = "poses"
"""The folder of recorded motions, which the base branch writes too."""
LANDSCAPES = "landscapes"
"""The folder of returns in worlds between and beyond the trained ones, which the base branch writes too."""
DIAGNOSTICS = "diagnostics"
"""The folder of what networks do on published observations, which the base branch writes too."""
TRAINED = "trained"
"""The folder of what the base branch trained itself: ``trained/2/`` has the runs of the second version of
``agent/`` that was merged, laid out as a submission, and ``trained/2.toml`` the record of that training."""
WRITTEN = (POSES, LANDSCAPES, DIAGNOSTICS, TRAINED)
"""The folders that the base branch writes."""
AGENT = "agent"
"""The folder of a submission's code, which the base branch trains."""
PROGRESS = ".progress"
"""The recorder's folder for unfinished runs. It is not part of a submission."""
IGNORED = (PROGRESS, f"{AGENT}/__pycache__")
"""What training leaves behind: Python compiles an agent that it loads."""
LOG, DOCUMENT, POLICIES, NETWORK = ".csv", ".json", ".npz", ".onnx"
"""The suffixes of the files of a run: its log, its document, its policies, and policies as ONNX networks."""

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
"""A submission's folder name. It becomes part of a URL."""
NAME_HINT = "Use 1 to 64 letters, digits, dots, dashes and underscores; start with a letter or digit."
RUN_FILE = re.compile(
    r"run(0|[1-9][0-9]{0,8})(\.csv|\.json|\.npz|\.stage(?:0|[1-9][0-9]{0,3})(?:\.[A-Za-z0-9_.-]{1,100})?\.onnx)"
)
"""The name of a file of a run; its groups are the run and the suffix."""
TRAINED_VERSION = re.compile(rf"{TRAINED}/([1-9][0-9]{{0,3}})")
RESERVED = frozenset(
    ["CON", "PRN", "AUX", "NUL", *(f"{name}{digit}" for name in ("COM", "LPT") for digit in range(10))]
)
"""Names that Windows reserves for devices, with any ending."""
CLONE = "A clone that converts line ends (core.autocrlf) or lacks Git LFS (git lfs pull) has other files."
"""A cause of files that differ from those that were written, for hints."""
ROOT = "."
"""The path of the submission's folder itself, listed only if it is none that can be read."""

MEBIBYTE = 2**20
MAX_FILE_BYTES = {
    ".md": MEBIBYTE // 16,
    ".toml": MEBIBYTE // 4,
    LOG: 8 * MEBIBYTE,
    DOCUMENT: 4 * MEBIBYTE,
    POLICIES: 64 * MEBIBYTE,
    NETWORK: 64 * MEBIBYTE,
    ".py": 100_000,
}
"""Largest file by suffix."""
MAX_POLICY_BYTES = 256 * MEBIBYTE
"""Largest size of the arrays of a run's policies."""
MAX_SUBMISSION_BYTES = 2048 * MEBIBYTE
MAX_FILES = 50_000
LIMITS = f"{MAX_FILES} files and {MAX_SUBMISSION_BYTES} bytes"
MAX_RUNS = 100
"""Most runs of a group and protocol."""
MAX_DEPTH = 4
"""Folder levels that are listed."""

OPEN_FLAGS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
"""Do not follow a link, do not wait for the writer of a FIFO, do not pass the file to other programs."""


def run_file(group_name: str, protocol: str, run: int, suffix: str) -> str:
    """The path of a file of a run inside the submission: ``hopper-gravity/sequential/run3.csv``."""
    return f"{group_name}/{protocol}/run{run}{suffix}"


def run_key(group_name: str, protocol: str, run: int) -> str:
    """The name of a run in review.toml: ``hopper-gravity/sequential/run3``."""
    return run_file(group_name, protocol, run, "")


def is_reserved(name: str) -> bool:
    """Whether some system reserves a file name, or ignores the dot or space at its end."""
    return name.partition(".")[0].upper().rstrip() in RESERVED or name.endswith((".", " "))


def max_bytes(path: str) -> int:
    """The size limit of a file, by its suffix; what the base branch writes has the largest."""
    if path == REVIEW or path.partition("/")[0] in WRITTEN:
        return MAX_FILE_BYTES[POLICIES]
    return MAX_FILE_BYTES.get(path[path.rfind(".") :], MEBIBYTE)


class FolderItem(NamedTuple):
    """A path inside the submission (with ``/``), its kind, and its size in bytes.

    The kind is ``file``, ``folder``, ``ignored``, or one that a submission may not contain: ``link``,
    ``device``, ``unreadable`` (a folder) or ``unreadable file``. The submission itself may also be
    ``missing`` or ``no folder``.
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
    groups: Mapping[str, TaskGroup]

    @functools.cached_property
    def files(self) -> dict[str, FolderItem]:
        """The regular files by path."""
        return {item.path: item for item in self.items if item.kind == "file"}

    @functools.cached_property
    def runs(self) -> dict[tuple[str, str], dict[int, set[str]]]:
        """The suffixes of the files of every run, by group name and protocol, in the order of the runs."""
        found: dict[tuple[str, str], dict[int, set[str]]] = {}
        for path in self.files:
            parts = path.split("/")
            match = RUN_FILE.fullmatch(parts[-1]) if len(parts) == 3 and parts[1] in PROTOCOLS else None
            if match:
                runs = found.setdefault((parts[0], parts[1]), {})
                runs.setdefault(int(match[1]), set()).add(match[2])
        return {key: dict(sorted(runs.items())) for key, runs in found.items()}

    @functools.cached_property
    def is_within_limits(self) -> bool:
        """Whether the files are few and small enough to be read."""
        total = sum(item.size for item in self.files.values())
        return len(self.files) <= MAX_FILES and total <= MAX_SUBMISSION_BYTES


def read_regular(path: Path, max_bytes: int) -> bytes:
    """The bytes of a regular file. Raises ``OSError`` if it is a link, another kind of file or larger."""
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0) | OPEN_FLAGS)
    with os.fdopen(descriptor, "rb") as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "It is not a regular file")
        data = file.read(max_bytes + 1)
    if len(data) > max_bytes:
        raise OSError(errno.EFBIG, f"It has more than {max_bytes} bytes")
    return data


def _items(folder: Path, prefix: str, depth: int) -> Iterator[FolderItem]:
    try:
        children = list(os.scandir(folder))
    except OSError:
        yield FolderItem(prefix.rstrip("/") or ROOT, "unreadable")
        return
    for child in children:
        path = f"{prefix}{escape(child.name)}"
        if path in IGNORED:
            yield FolderItem(path, "ignored")
        elif child.is_symlink():
            yield FolderItem(path, "link")
        elif child.is_dir(follow_symlinks=False):
            yield FolderItem(path, "folder")
            if depth < MAX_DEPTH and not TRAINED_VERSION.fullmatch(path):
                yield from _items(Path(child.path), f"{path}/", depth + 1)
        elif child.is_file(follow_symlinks=False):
            try:
                yield FolderItem(path, "file", child.stat(follow_symlinks=False).st_size)
            except OSError:
                yield FolderItem(path, "unreadable file")
        else:
            yield FolderItem(path, "device")


def _exists_readable(path: Path, kind: Callable[[Path], bool] = Path.exists) -> bool:
    """``kind(path)``, or False where permission is denied."""
    try:
        return kind(path)
    except OSError:
        return False


def scan(root: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> Folder:
    """The folder as it is on disk. A link, or a path that is not a folder, is its only item, ``ROOT``."""
    if _exists_readable(root, Path.is_symlink):
        items = [FolderItem(ROOT, "link")]
    elif _exists_readable(root, Path.is_dir):
        items = sorted(_items(root, "", 1))
    else:
        items = [FolderItem(ROOT, "no folder" if _exists_readable(root) else "missing")]
    return Folder(root, escape(root.name or root.resolve().name), tuple(items), groups)


def _is_left_over(folder: Path) -> bool:
    """Whether a folder, not a link to one, contains only that of unfinished runs."""
    try:
        return not folder.is_symlink() and [child.name for child in folder.iterdir()] == [PROGRESS]
    except OSError:
        return False


def latest_version(paths: Iterable[str]) -> int:
    """The latest version of the code that has a record of training, by paths in the submission; else 0."""
    records = (re.fullmatch(rf"{TRAINED_VERSION.pattern}\.toml", path) for path in paths)
    return max((int(match[1]) for match in records if match), default=0)


def _folders_at(path: Path) -> list[Path]:
    """The submission at a path, or all those in a folder of submissions."""
    if not os.path.lexists(path):
        hint = "Name a submission, or a folder of submissions."
        if "submissions" in path.parts[-2:]:
            part = "disable" if path.name == "submissions" else f"add submissions/{escape(path.name)}"
            hint += f" What a clone leaves out is fetched by: git sparse-checkout {part}"
        raise BenchError("no-such-folder", "There is no such folder.", escape(str(path)), hint)
    target = path.resolve() if path.is_symlink() or path.name in ("", "..") else path
    if _exists_readable(target / MANIFEST):
        return [target]
    if _exists_readable(target.parent / MANIFEST):
        message = f"It is a part of the submission {escape(target.parent.name)}."
        raise BenchError("no-such-folder", message, escape(str(path)), "Name the submission.")
    try:
        children = sorted(child for child in target.iterdir() if not child.name.startswith("."))
    except OSError:
        return [target]
    if not any(_exists_readable(child / MANIFEST) for child in children):
        return [target]
    kinds = (Path.is_dir, Path.is_symlink)
    folders = [child for child in children if any(_exists_readable(child, kind) for kind in kinds)]
    return [folder for folder in folders if not _is_left_over(folder)]


def submission_folders(paths: list[Path]) -> list[Path]:
    """The submissions at the given paths, sorted by name. A folder of submissions means all of them, without
    folders that contain only ``.progress``: git leaves such a folder when it switches to another branch.

    Raises ``BenchError`` if a path does not exist or is inside a submission, or two have the same name.
    """
    by_name: dict[str, Path] = {}
    for folder in (folder for path in paths for folder in _folders_at(path)):
        first = by_name.setdefault(unicodedata.normalize("NFKC", folder.name).casefold(), folder)
        if first.absolute() != folder.absolute():
            same = first.name == folder.name
            names = f"the name {escape(folder.name)!r}" if same else "names that differ only in letter case"
            message = f"Two submissions have {names}: {first} and {folder}."
            raise BenchError("two-of-one-name", escape(message), hint="Score one at a time, or rename one.")
    return sorted(by_name.values(), key=lambda folder: folder.name)
