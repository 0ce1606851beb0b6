"""Rules about the folder: which files a submission may contain, their names and sizes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.auditing.salt import salt_of
from gym_extensions.rollouts.folder import ROOT, Folder, exists_readable
from gym_extensions.rollouts.layout import (
    ARRAY_FOLDERS,
    CSV_FILES,
    LOGS,
    MANIFEST,
    MAX_CSV_BYTES,
    MAX_DEPTH,
    MAX_FILES,
    MAX_SUBMISSION_BYTES,
    NAME,
    POLICIES,
    POLICY,
    PROGRESS,
    README,
    SALT_FILE,
    TRACE,
    TRACES,
    is_reserved,
    max_bytes,
)
from gym_extensions.rollouts.problem import Finding
from gym_extensions.rollouts.rules.rule import rule

REPLACE = "Replace it by the file itself."
READABLE = "Add read permission, or copy it again."
IRREGULAR = {
    "link": ("It is a symbolic link.", REPLACE),
    "device": ("It is neither a file nor a folder.", REPLACE),
    "unreadable": ("The folder cannot be read.", READABLE),
    "unreadable file": ("The file cannot be read.", READABLE),
}
"""Message and hint by kind of item."""


@dataclass(frozen=True)
class UnreadableFile:
    """A file that could not be opened, and the operating system's reason."""

    path: str
    reason: str


@dataclass(frozen=True)
class SaltFile:
    """The path and the bytes of a file ``salt.txt``."""

    path: str
    data: bytes


@rule("folder")
def not_a_submission(folder: Folder) -> Iterator[Finding]:
    """A submission is a folder that contains submission.toml."""
    if exists_readable(folder.root, Path.is_symlink) or any(item.path == ROOT for item in folder.items):
        return  # not_a_regular_file reports it
    if not exists_readable(folder.root, Path.is_dir):
        problem = "is not a folder" if exists_readable(folder.root) else "does not exist"
        hint = f"Name a folder that contains {MANIFEST}."
        yield Finding(folder.name, f"'{folder.name}' {problem}.", hint)
    elif not any(item.path == MANIFEST and item.kind != "folder" for item in folder.items):
        hint = f"Write {MANIFEST} as described in docs/rollout-log.md, or name the folder that contains it."
        if not folder.items and exists_readable(folder.root / PROGRESS):
            hint = "It contains only unfinished runs: repeat the command that trains them."
        yield Finding(folder.name, f"The folder contains no {MANIFEST}.", hint)


@rule("folder")
def folder_name(folder: Folder) -> Iterator[Finding]:
    """The folder's name has 1 to 64 letters, digits, dots, dashes and underscores and starts with a letter or
    digit, because it becomes part of a URL. No system reserves it (CON, NUL, …), and it does not end in a
    dot."""
    if not NAME.fullmatch(folder.name) or is_reserved(folder.name):
        hint = "Use 1 to 64 letters, digits, dots, dashes and underscores; start with a letter or digit."
        yield Finding(folder.name, f"The folder's name is '{folder.name}'.", hint)


@rule("folder")
def not_a_regular_file(folder: Folder) -> Iterator[Finding]:
    """A submission contains only folders and regular files: no symbolic links, no devices."""
    if exists_readable(folder.root, Path.is_symlink):
        yield Finding(folder.name, "It is a symbolic link.", "Replace it by the folder itself.")
    for item in folder.items:
        if item.kind in IRREGULAR:
            path = folder.name if item.path == ROOT else item.path
            yield Finding(path, *IRREGULAR[item.kind])


@rule("folder")
def unknown_group(folder: Folder) -> Iterator[Finding]:
    """Each folder in a submission is named after a published group, without its version.
    (`score --groups` adds custom groups.)"""
    for item in folder.items:
        if item.kind == "folder" and "/" not in item.path and item.path not in folder.groups:
            closest = did_you_mean(item.path, folder.groups)
            custom = "For a custom group, pass its TOML file with --groups, where the command has it."
            hint = f"{closest} {custom}".lstrip()
            yield Finding(item.path, f"Unknown group '{item.path}'.", hint)


def _is_expected(path: str, groups: Mapping[str, TaskGroup]) -> bool:
    parts = path.split("/")
    if len(parts) == 1:
        return path in (MANIFEST, README)
    if parts[0] not in groups:
        return True  # unknown_group reports it
    if len(parts) == 2:
        return parts[1] in CSV_FILES
    if len(parts) != 3 or parts[1] not in ARRAY_FOLDERS:
        return False
    if parts[1] == POLICIES:
        match = POLICY.fullmatch(parts[2])
        if match is not None and match[1] != "single":
            return match[4] is None
    else:
        match = TRACE.fullmatch(parts[2])
    is_salt = parts[1:] == [TRACES, SALT_FILE]
    names = [task.name for task in groups[parts[0]].tasks]
    return is_salt or (match is not None and match[4] in names)


@rule("folder")
def unexpected_name(folder: Folder) -> Iterator[Finding]:
    """A submission contains only the files and folders that docs/rollout-log.md lists."""
    for item in folder.items:
        parts = item.path.split("/")
        if item.kind == "folder":
            is_deep = len(parts) > 2 or (len(parts) == 2 and parts[1] not in ARRAY_FOLDERS)
            if is_deep and len(parts) <= MAX_DEPTH and parts[0] in folder.groups:
                yield Finding(item.path, "Unexpected folder.", "Remove it.")
        elif item.kind == "file" and not _is_expected(item.path, folder.groups):
            choices = (MANIFEST, README) if len(parts) == 1 else CSV_FILES
            closest = did_you_mean(parts[-1], choices) if len(parts) <= 2 else ""
            other = "Remove it, or rename it as described in docs/rollout-log.md."
            yield Finding(item.path, "Unexpected file.", closest if closest.startswith("Did") else other)


@rule("folder")
def no_logs(folder: Folder) -> Iterator[Finding]:
    """Each group folder contains at least one of sequential.csv, single.csv and joint.csv."""
    paths = {item.path for item in folder.items if item.kind != "folder"}
    for item in folder.items:
        is_group = item.kind == "folder" and item.path in folder.groups
        if is_group and not any(f"{item.path}/{log}" in paths for log in LOGS):
            hint = f"Add one of {', '.join(LOGS)}, or remove the folder."
            yield Finding(item.path, "The group folder contains no log.", hint)


@rule("folder")
def too_large(folder: Folder) -> Iterator[Finding]:
    """A submission keeps to the limits on the size of a file, the total sizes and the number of files."""
    for item in folder.files.values():
        limit = max_bytes(item.path)
        if item.size > limit:
            message = f"The file has {item.size} bytes; the limit is {limit}."
            yield Finding(item.path, message, "Leave out everything that the format does not need.")
    size = folder.size
    if size.files > MAX_FILES or size.total > MAX_SUBMISSION_BYTES:
        limits = f"{MAX_FILES} files and {MAX_SUBMISSION_BYTES} bytes"
        message = f"The submission has {size.files} files and {size.total} bytes; the limits are {limits}."
        hint = "Include only the traces of the audit sample, and move the rest to an archive."
        yield Finding(folder.name, message, hint)
    if size.csv > MAX_CSV_BYTES:
        message = f"The CSV files have {size.csv} bytes; the limit is {MAX_CSV_BYTES}."
        yield Finding(folder.name, message, "Submit fewer runs or points of curves.")


@rule("unreadable")
def unreadable_file(file: UnreadableFile) -> Iterator[Finding]:
    """Every file of a submission can be read."""
    yield Finding(file.path, f"The file cannot be read: {file.reason}.", READABLE)


@rule("salt")
def malformed_salt(file: SaltFile) -> Iterator[Finding]:
    """traces/salt.txt is 64 hexadecimal digits and a line end."""
    if salt_of(file.data) is None:
        hint = "Run gym-extensions trace with the salt, which writes the file."
        yield Finding(
            file.path, "The file is not 64 hexadecimal digits (0 to 9, a to f) and a line end.", hint
        )
