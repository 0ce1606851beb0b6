"""Scorecards kept by content: an unchanged folder is not scored again; anything doubtful is made anew."""

from __future__ import annotations

import functools
import hashlib
import json
from pathlib import Path
from typing import Any

from gym_extensions import catalog, scoring
from gym_extensions.atomic import write_text
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import max_bytes

Document = dict[str, Any]


@functools.cache
def code_digest() -> str:
    """A digest of the code and the data that a scorecard depends on, but for the references of a version."""
    digest = hashlib.sha256()
    for package in (catalog, scoring):
        root = Path(str(package.__file__)).parent
        for path in sorted(root.rglob("*")):
            name = path.relative_to(root).as_posix()
            version = name.startswith("references/") and path.suffix == ".json"
            if path.suffix in (".py", ".json", ".csv", ".txt") and not version:
                digest.update(f"{name}\n{path.stat().st_size}\n".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()


def content_key(folder: Folder, references: str) -> str:
    """A digest of a submission's name and every byte in it, of the references and of the code.

    Args:
        folder: the submission as it lies on disk.
        references: the digest of the references.
    """
    place = f"{folder.name}\n{folder.root.is_symlink()}"
    digest = hashlib.sha256(f"{code_digest()}\n{references}\n{place}\n".encode())
    for entry in folder.items:
        digest.update(f"{entry.path}\n{entry.kind}\n{entry.size}\n".encode())
        if entry.kind == "file" and entry.size <= max_bytes(entry.path):
            try:
                digest.update(hashlib.sha256(folder.read(entry.path)).digest())
            except OSError as error:
                digest.update(f"unreadable {error.errno}".encode())
    return digest.hexdigest()


def _text(card: Document) -> str:
    return json.dumps(card, separators=(",", ":"), ensure_ascii=True, allow_nan=False)


def keep(place: Path, key: str, card: Document) -> None:
    """Writes a scorecard under its key, whole or not at all, its parts in the order that they have.

    Raises BenchError where the place cannot be written.
    """
    body = _text(card)
    digest = hashlib.sha256(body.encode()).hexdigest()
    try:
        write_text(place, f'{{"key":"{key}","sha256":"{digest}","card":{body}}}\n')
    except OSError as error:
        hint = "Choose another folder for --cache, or leave it out."
        raise BenchError("not-written", f"{error.strerror or error}.", str(place), hint) from error


def kept(place: Path, key: str) -> Document | None:
    """The scorecard kept under a key; None where there is none, or a wrong, old or half-written one."""
    try:
        found = json.loads(place.read_bytes())
        if found["key"] != key:
            return None
        card: Document = found["card"]
        digest = hashlib.sha256(_text(card).encode()).hexdigest()
        return card if digest == found["sha256"] else None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
