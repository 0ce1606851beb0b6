"""What entries take in the repository, from the committed files."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

STORED = ("traces", "policies")
"""Folders of a group whose files count towards the limit."""
MAX_MEGABYTES = 200
"""The limit for all entries (docs/adr/0090-identical-files-count-once.md)."""


def stored_megabytes(
    submissions: Path, entry: str = "*", group_name: str = "*", protocol: str = "*"
) -> float:
    """Size of the audit samples and policies of submissions in MB. Identical files count once."""
    paths = [
        path
        for folder in STORED
        for path in submissions.glob(f"{entry}/{group_name}/{folder}/{protocol}-*.npz")
    ]
    sizes = {hashlib.sha256(path.read_bytes()).digest(): path.stat().st_size for path in paths}
    return sum(sizes.values()) / 1e6


@dataclass(frozen=True)
class Space:
    """Size of audit samples and policies in MB.

    Attributes:
        limit: the most that all entries may take.
        used: what they take.
        smallest: the group on which sequential runs of the entry take least, with their size.
        largest: that on which they take most.
    """

    limit: int
    used: float
    smallest: tuple[str, float]
    largest: tuple[str, float]

    @classmethod
    def of(cls, submissions: Path, entry: str, groups: Iterable[str]) -> Space | None:
        """The space of the entries in a folder, and that of one entry on its groups; None if it has none."""
        sizes = [(name, stored_megabytes(submissions, entry, name, "sequential")) for name in groups]
        if not sizes:
            return None
        smallest, largest = (choose(sizes, key=lambda item: item[1]) for choose in (min, max))
        return cls(MAX_MEGABYTES, stored_megabytes(submissions), smallest, largest)
