"""The digest of all files of a submission, in a folder or in a commit.

It names what the ledger accepted, and is the SHA-256 of what ``sha256sum`` prints for the
files, sorted by path. In the folder::

    find * -type f | LC_ALL=C sort | xargs sha256sum | sha256sum
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from gym_extensions.curation.git import Repository, TreeEntry
from gym_extensions.rollouts.folder import scan


def digest_of(hashes: Mapping[str, str]) -> str:
    """The digest of files.

    Args:
        hashes: the SHA-256 of each file, 64 hexadecimal digits, by path inside the submission (with ``/``).
    """
    lines = sorted(f"{path}\0{sha256}" for path, sha256 in hashes.items())
    text = "".join("{1}  {0}\n".format(*line.split("\0")) for line in lines)
    return hashlib.sha256(text.encode()).hexdigest()


def folder_hashes(root: Path) -> dict[str, str]:
    """The SHA-256 of each file of a submission's folder; the recorder's ``.progress`` is left out.

    Raises:
        OSError: a file cannot be read.
    """
    folder = scan(root)
    return {path: hashlib.sha256(folder.read(path)).hexdigest() for path in folder.files}


def folder_digest(root: Path) -> str:
    """The digest of all files of a submission's folder. Raises as ``folder_hashes``."""
    return digest_of(folder_hashes(root))


def tree_hashes(repository: Repository, entries: Sequence[TreeEntry], prefix: str) -> dict[str, str]:
    """The SHA-256 of each file of a submission in a commit.

    Args:
        repository: the repository.
        entries: the submission's files.
        prefix: the folder of the submission with ``/`` at the end, which their paths begin with.
    """
    contents = repository.blobs(entry.object_id for entry in entries)
    return {
        entry.path.removeprefix(prefix): hashlib.sha256(content).hexdigest()
        for entry, content in zip(entries, contents, strict=True)
    }


def tree_digest(repository: Repository, entries: Sequence[TreeEntry], prefix: str) -> str:
    """The digest of all files of a submission in a commit; the arguments are those of ``tree_hashes``."""
    return digest_of(tree_hashes(repository, entries, prefix))
