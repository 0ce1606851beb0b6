"""The digest of a submission, which names its content without the traces."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.layout import TRACES


def submission_digest(folder: Path) -> str:
    """The SHA-256 of a submission's files except its traces, as 64 hexadecimal digits.

    The name of the submission's folder is not part of it.

    Raises:
        OSError: a file cannot be read.
    """
    listing = scan(folder)
    paths = (path for path in listing.files if not _is_trace(path))
    return digest_without_traces({path: hashlib.sha256(listing.read(path)).hexdigest() for path in paths})


def digest_without_traces(hashes: Mapping[str, str]) -> str:
    """The SHA-256 of one line per file, sorted by path: path, space, hexadecimal SHA-256, line end.

    The folders ``traces`` are left out, because a salt that is fixed after this digest draws them.

    Args:
        hashes: the SHA-256 of each file by path inside the submission.
    """
    lines = (f"{path} {hashes[path]}\n" for path in sorted(hashes) if not _is_trace(path))
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _is_trace(path: str) -> bool:
    return path.split("/")[1:2] == [TRACES]
