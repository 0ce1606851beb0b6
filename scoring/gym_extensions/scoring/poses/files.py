"""The files of poses: one per entry and group, in a folder per entry."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.scoring.poses.model import Poses

FOLDER = Path("scoring/poses")
"""The committed poses, relative to the root of the repository."""


def path_of(folder: Path, submission: str, group_name: str) -> Path:
    """The file of an entry's poses on a group."""
    return folder / submission / f"{group_name}.json"


def write(folder: Path, group_name: str, poses: Poses) -> Path:
    """Writes a document and returns its path."""
    path = path_of(folder, poses.submission, group_name)
    write_text(path, poses.to_json())
    return path


def load(path: Path) -> Poses | None:
    """The document of a file, or None if there is no such file.

    Raises:
        BenchError: the file is not a document of poses.
    """
    return Poses.load(path, "bad-poses", "gym-extensions watch")


def load_entry(folder: Path | None, submission: str) -> dict[str, Poses]:
    """The poses of an entry by group id, sorted. Raises ``BenchError`` if a file cannot be read."""
    if folder is None:
        return {}
    documents = [load(path) for path in sorted((folder / submission).glob("*.json"))]
    return {document.group: document for document in documents if document is not None}
