"""What a pull request changes, from ``git diff-tree`` and ``git ls-tree``."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from gym_extensions.curation.git import Repository, TreeEntry
from gym_extensions.curation.ledger.chain import FILE
from gym_extensions.rollouts.layout import TRACES

SUBMISSIONS = "submissions"
CHALLENGES = "challenges"
LEDGER = f"{SUBMISSIONS}/{FILE}"
RENAMES = ("R", "C")


@dataclass(frozen=True)
class Change:
    """A changed file.

    ``status`` is git's letter: ``A`` added, ``M`` modified, ``D`` deleted, ``T`` type changed, ``R`` renamed.
    ``mode`` is the new file mode, and ``source`` the old path of a renamed file, else empty.
    """

    status: str
    mode: str
    path: str
    source: str = ""


@dataclass(frozen=True)
class PullRequest:
    """The commits of a pull request: where it started, the branch that it is for, and its own last commit."""

    repository: Repository
    start: str
    base: str
    head: str

    @cached_property
    def changes(self) -> tuple[Change, ...]:
        """Its changed files, sorted by path. Files that moved with the same content are renames."""
        arguments = ("-r", "-z", "--raw", "--no-ext-diff", "--no-textconv", "-M100%", self.start, self.head)
        fields = iter(self.repository.run("diff-tree", *arguments).split(b"\0"))
        return tuple(sorted(_changes(fields), key=lambda change: change.path))

    @cached_property
    def base_files(self) -> tuple[TreeEntry, ...]:
        """The files of submissions on the branch that it is for."""
        return self.repository.tree(self.base, SUBMISSIONS)

    @cached_property
    def head_files(self) -> tuple[TreeEntry, ...]:
        """The files of submissions and challenges in its last commit."""
        return self.repository.tree(self.head, SUBMISSIONS) + self.repository.tree(self.head, CHALLENGES)

    @cached_property
    def base_entries(self) -> frozenset[str]:
        """The names of the entries on the branch that it is for."""
        parts = (entry.path.split("/") for entry in self.base_files)
        return frozenset(names[1] for names in parts if len(names) > 2)

    @cached_property
    def entries(self) -> tuple[str, ...]:
        """The names of the entries whose files it changes, sorted."""
        parts = (path.split("/") for path in self.paths)
        return tuple(sorted({names[1] for names in parts if names[0] == SUBMISSIONS and len(names) > 2}))

    @cached_property
    def paths(self) -> tuple[str, ...]:
        """Every path that it changes, old paths of renamed files included, sorted."""
        return tuple(sorted({path for item in self.changes for path in (item.path, item.source) if path}))

    def files_of(self, entry: str) -> tuple[TreeEntry, ...]:
        """The files of an entry in its last commit."""
        return tuple(item for item in self.head_files if item.path.startswith(f"{SUBMISSIONS}/{entry}/"))


def _changes(fields: Iterator[bytes]) -> Iterator[Change]:
    for meta in fields:
        if not meta:
            return
        _, mode, _, _, status = meta.decode().split()
        path = os.fsdecode(next(fields))
        if status[0] in RENAMES:
            yield Change(status[0], mode, os.fsdecode(next(fields)), source=path)
        else:
            yield Change(status[0], mode, path)


def is_data(path: str) -> bool:
    """Whether a path is in the folder of submissions or challenges, in any letter case."""
    return path.split("/", maxsplit=1)[0].casefold() in (SUBMISSIONS, CHALLENGES)


def is_trace(path: str) -> bool:
    """Whether a path is a file in a folder of traces of an entry."""
    names = path.split("/")
    return len(names) == 5 and (names[0], names[3]) == (SUBMISSIONS, TRACES)
