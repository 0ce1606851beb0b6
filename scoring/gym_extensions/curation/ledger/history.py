"""Compares a ledger with the versions of its file in git: lines are only ever appended."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.chain import FILE
from gym_extensions.errors import BenchError


def first_difference(old: bytes, new: bytes) -> int | None:
    """The number of the first line of ``old`` that ``new`` lacks at that row; None if it has all."""
    if new.startswith(old):
        return None
    later = new.split(b"\n")
    for number, line in enumerate(old.split(b"\n"), 1):
        if number > len(later) or later[number - 1] != line:
            return number
    return None


def require_appended(old: bytes, new: bytes, where: str, version: str) -> None:
    """Raises BenchError unless ``new`` consists of ``old`` and further lines.

    Args:
        old: an earlier version of the ledger.
        new: a later one.
        where: the file of the later version.
        version: names the earlier version, for the error.
    """
    number = first_difference(old, new)
    if number is not None:
        message = f"Row {number} is not the one of {version}: an old line was edited, moved or removed."
        hint = "Lines are never changed: restore the old ones and append a new line."
        raise BenchError("ledger-edited", message, where, hint)


def check_history(folder: Path) -> int:
    """Compares the ledger of a folder with all of its versions in git and returns their number.

    The versions are those of the first-parent history of HEAD, which on the main branch are its own commits.

    Raises:
        BenchError: an old line was edited (``ledger-edited``), the file was removed for a time
            (``ledger-removed``), the clone is shallow (``shallow-clone``) or the folder is not in git.
    """
    repository = Repository(folder)
    path = folder.resolve().relative_to(repository.top.resolve()).joinpath(FILE).as_posix()
    where = str(folder / FILE)
    if repository.is_shallow:
        hint = "Run `git fetch --unshallow`, or check the chain alone with --no-history."
        raise BenchError("shallow-clone", "The clone lacks older commits.", where, hint)
    top = Repository(repository.top)
    commits = top.versions(path)
    later, name = (folder / FILE).read_bytes(), where
    for commit in reversed(commits):
        content = top.file(commit, path)
        if content is None:
            message = f"Commit {commit[:12]} removed the ledger."
            raise BenchError("ledger-removed", message, where, "Append to the ledger; never start it anew.")
        require_appended(content, later, name, f"commit {commit[:12]}")
        later, name = content, f"{path} at commit {commit[:12]}"
    return len(commits)
