"""Rules about the names of files and folders."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator

from gym_extensions.curation.gate.changes import PullRequest
from gym_extensions.curation.gate.rules.rule import rule
from gym_extensions.rollouts.layout import NAME, is_reserved
from gym_extensions.rollouts.problem import Finding

COMPONENT = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
MAX_PATH = 200
"""Characters of a path."""


@rule
def reserved_name(pull_request: PullRequest) -> Iterator[Finding]:
    """No file or folder has a name that some system reserves (CON, NUL, …) or ends in a dot or space."""
    for change in pull_request.changes:
        for name in change.path.split("/"):
            if is_reserved(name):
                yield Finding(change.path, f"The name {name!r} is reserved on some systems.", "Rename it.")


@rule
def path_characters(pull_request: PullRequest) -> Iterator[Finding]:
    """Names have ASCII letters, digits, dots, dashes and underscores, and start with a letter or digit. A
    path has at most 200 characters."""
    for change in pull_request.changes:
        if not all(map(COMPONENT.fullmatch, change.path.split("/"))) or len(change.path) > MAX_PATH:
            hint = "Use letters, digits, dots, dashes and underscores, at most 200 in all."
            yield Finding(change.path[:MAX_PATH], "The path has other characters or is too long.", hint)


@rule
def entry_name(pull_request: PullRequest) -> Iterator[Finding]:
    """The name of an entry is that of a submission's folder: 1 to 64 such characters."""
    for name in pull_request.entries:
        if not NAME.fullmatch(name):
            yield Finding(f"submissions/{name[:MAX_PATH]}", "It is not a name of an entry.", "Rename it.")


def _fold(path: str) -> str:
    return unicodedata.normalize("NFKC", path).casefold()


@rule
def case_collision(pull_request: PullRequest) -> Iterator[Finding]:
    """No two paths differ only in letter case or Unicode spelling, among all entries."""
    spellings: dict[str, str] = {}
    changed = {change.path for change in pull_request.changes}
    for entry in (*pull_request.base_files, *pull_request.head_files):
        names = entry.path.split("/")
        for depth in range(1, len(names) + 1):
            path = "/".join(names[:depth])
            first = spellings.setdefault(_fold(path), path)
            if first != path and entry.path in changed:
                yield Finding(entry.path, f"{path} and {first} differ only in letter case.", "Rename it.")
                break
