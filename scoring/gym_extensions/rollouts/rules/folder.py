"""Rules about the folder: what may lie in it, under which names, how large."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.folder import HERE, Folder, seen
from gym_extensions.rollouts.layout import (
    ARRAY_FOLDERS,
    CSV_FILES,
    DEEPEST,
    LARGEST_SUBMISSION,
    LOGS,
    MANIFEST,
    MOST_FILES,
    NAME,
    POLICY,
    TRACE,
    largest,
)
from gym_extensions.rollouts.problem import Finding
from gym_extensions.rollouts.rules.rule import rule

ODD_KINDS = {
    "link": "a symbolic link",
    "device": "neither a file nor a folder",
    "unreadable": "a folder that cannot be read",
    "shut": "a file that cannot be read",
}
ODD_HINTS = {
    "link": "Put the file itself in its place.",
    "device": "Put the file itself in its place.",
    "unreadable": "Give it read permission, or copy it again.",
    "shut": "Give its folder read permission, or copy it again.",
}


@rule("folder")
def not_a_submission(folder: Folder) -> Iterator[Finding]:
    """A submission is a folder that holds a file submission.toml."""
    if seen(folder.root, Path.is_symlink) or any(entry.path == HERE for entry in folder.entries):
        return  # not_a_regular_file tells it
    if not seen(folder.root, Path.is_dir):
        what = "is not a folder" if seen(folder.root) else "does not exist"
        yield Finding(folder.name, f"'{folder.name}' {what}.", f"Name a folder that holds {MANIFEST}.")
    elif not any(entry.path == MANIFEST and entry.kind != "folder" for entry in folder.entries):
        hint = f"Write {MANIFEST} as docs/rollout-log.md says, or name the folder that holds it."
        yield Finding(folder.name, f"There is no {MANIFEST} in it.", hint)


@rule("folder")
def folder_name(folder: Folder) -> Iterator[Finding]:
    """The folder's name is up to 64 letters, digits, dots, dashes, underscores, a letter or digit first: it
    becomes an address."""
    if not NAME.fullmatch(folder.name):
        hint = "Rename it with a letter or digit, then those, dots, dashes and underscores, 64 in all."
        yield Finding(folder.name, f"The folder's name is '{folder.name}'.", hint)


@rule("folder")
def not_a_regular_file(folder: Folder) -> Iterator[Finding]:
    """Everything in a submission is a folder or a regular file: no symbolic link, no device."""
    if seen(folder.root, Path.is_symlink):
        yield Finding(folder.name, "This is a symbolic link.", "Put the folder itself in its place.")
    for entry in folder.entries:
        if entry.kind not in ("file", "folder"):
            path = folder.name if entry.path == HERE else entry.path
            yield Finding(path, f"This is {ODD_KINDS[entry.kind]}.", ODD_HINTS[entry.kind])


@rule("folder")
def unknown_group(folder: Folder) -> Iterator[Finding]:
    """Each folder in a submission is named after a published group, without its version."""
    for entry in folder.entries:
        if entry.kind == "folder" and "/" not in entry.path and entry.path not in GROUPS:
            hint = did_you_mean(entry.path, GROUPS) or "Groups are listed by: gym-extensions envs list."
            yield Finding(entry.path, f"There is no group '{entry.path}'.", hint)


def _expected(path: str) -> bool:
    parts = path.split("/")
    if len(parts) == 1:
        return path == MANIFEST
    if parts[0] not in GROUPS:
        return True  # unknown_group has told it
    if len(parts) == 2:
        return parts[1] in CSV_FILES
    if len(parts) != 3 or parts[1] not in ARRAY_FOLDERS:
        return False
    if parts[1] == "policies":
        return POLICY.fullmatch(parts[2]) is not None
    match = TRACE.fullmatch(parts[2])
    return match is not None and any(match[4] == task.name for task in GROUPS[parts[0]].tasks)


@rule("folder")
def unexpected_name(folder: Folder) -> Iterator[Finding]:
    """Only the files that docs/rollout-log.md names lie in a submission, each in its place."""
    for entry in folder.entries:
        parts = entry.path.split("/")
        if entry.kind == "folder":
            deep = len(parts) > 2 or (len(parts) == 2 and parts[1] not in ARRAY_FOLDERS)
            if deep and len(parts) <= DEEPEST and parts[0] in GROUPS:
                yield Finding(entry.path, "A folder of this name has no place here.", "Remove it.")
        elif entry.kind == "file" and not _expected(entry.path):
            choices = (MANIFEST,) if len(parts) == 1 else CSV_FILES
            close = did_you_mean(parts[-1], choices) if len(parts) <= 2 else ""
            hint = (
                close
                if close.startswith("Did")
                else "Remove it, or give it the name that docs/rollout-log.md says."
            )
            yield Finding(entry.path, "A file of this name has no place here.", hint)


@rule("folder")
def no_logs(folder: Folder) -> Iterator[Finding]:
    """Each group's folder holds at least one of sequential.csv, single.csv and joint.csv."""
    there = {entry.path for entry in folder.entries if entry.kind != "folder"}
    for entry in folder.entries:
        known = entry.kind == "folder" and entry.path in GROUPS and entry.path not in there
        if known and not any(f"{entry.path}/{log}" in there for log in LOGS):
            yield Finding(
                entry.path, "There is no log in it.", f"Add one of {', '.join(LOGS)}, or remove the folder."
            )


@rule("folder")
def too_large(folder: Folder) -> Iterator[Finding]:
    """A submission keeps within the limits on the size of a file, the size of all and their number."""
    for entry in folder.files():
        limit = largest(entry.path)
        if entry.size > limit:
            found = f"The file has {entry.size} bytes; the limit is {limit}."
            yield Finding(entry.path, found, "Leave out what the format does not ask for.")
    total, count = sum(entry.size for entry in folder.files()), len(folder.files())
    if total > LARGEST_SUBMISSION or count > MOST_FILES:
        found = (
            f"It has {count} files of {total} bytes; the limits are {MOST_FILES} and {LARGEST_SUBMISSION}."
        )
        yield Finding(
            folder.name, found, "Keep the audit sample of traces, and put the rest into an archive."
        )
