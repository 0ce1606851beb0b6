"""The digest of a submission, which names its content without the traces."""

from __future__ import annotations

import hashlib
from pathlib import Path

from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.layout import TRACES


def submission_digest(folder: Path) -> str:
    """The SHA-256 of a submission's files except its traces, as 64 hexadecimal digits.

    It covers one line per file, sorted by path: the path inside the submission, a space, the hexadecimal
    SHA-256 of the content, and a line end. The folders ``traces`` are left out, because a salt that is fixed
    after this digest draws them. The name of the submission's folder is not part of it.

    Raises:
        OSError: a file cannot be read.
    """
    listing = scan(folder)
    paths = sorted(path for path in listing.files if path.split("/")[1:2] != [TRACES])
    lines = (f"{path} {hashlib.sha256(listing.read(path)).hexdigest()}\n" for path in paths)
    return hashlib.sha256("".join(lines).encode()).hexdigest()
