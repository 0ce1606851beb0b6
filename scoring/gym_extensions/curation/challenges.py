"""Challenges: texts that doubt an entry, one file each, shown as they are."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from gym_extensions.errors import BenchError
from gym_extensions.rollouts import rules
from gym_extensions.scoring.scorecard.record import Challenge

FOLDER = "challenges"
"""The folder of challenges, beside the folder of the submissions: ``challenges/<entry>/<name>.txt``."""
PATH = re.compile(r"challenges/([A-Za-z0-9][A-Za-z0-9._-]{0,63})/([A-Za-z0-9][A-Za-z0-9._-]{0,63})\.txt")
MAX_BYTES = 64 * 1024


def challenge(path: str, data: bytes) -> Challenge:
    """The challenge in a file.

    Args:
        path: the file's path in the repository.
        data: its content.

    Raises:
        BenchError: the path is not one of a challenge, or the file is too large or not plain text.
    """
    if not PATH.fullmatch(path):
        hint = "Name it challenges/<entry>/<name>.txt."
        raise BenchError("challenge-name", "It is not a name of a challenge.", path, hint)
    if len(data) > MAX_BYTES:
        raise BenchError("challenge-size", f"It has more than {MAX_BYTES} bytes.", path, "Shorten it.")
    problems = rules.problems("readme", data)
    if problems or not data.strip():
        message = problems[0].message if problems else "It is empty."
        raise BenchError("challenge-text", message, path, "Write plain UTF-8 text.")
    return Challenge(path, data.decode("utf-8").replace("\r\n", "\n"))


def read_challenges(top: Path) -> tuple[Challenge, ...]:
    """All challenges in a repository's folder, sorted by path. Raises BenchError as ``challenge``."""
    paths = [path for path in sorted((top / FOLDER).rglob("*")) if not path.is_dir() or path.is_symlink()]
    names = [path.relative_to(top).as_posix() for path in paths]
    for name, path in zip(names, paths, strict=True):
        if path.is_symlink():
            raise BenchError("challenge-name", "It is a symbolic link.", name, "Replace it by a file.")
    return tuple(challenge(name, path.read_bytes()) for name, path in zip(names, paths, strict=True))


def challenges_of(entry: str, challenges: Sequence[Challenge]) -> tuple[Challenge, ...]:
    """The challenges of an entry."""
    return tuple(item for item in challenges if item.file.split("/")[1] == entry)
