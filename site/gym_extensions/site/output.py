"""Writes the files of a site into a folder: only what changed, and all of it or nothing.

The new site is prepared beside the old one. Files whose inputs did not change are linked from the old site,
and the folders are swapped at the end. The file ``.gym-extensions-site`` marks a site, so that a build never
replaces another folder, and holds per path the digests of its inputs and of its content.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

import msgspec

from gym_extensions.atomic import replace_folder
from gym_extensions.errors import BenchError

MARK = ".gym-extensions-site"


def digest(*parts: bytes) -> str:
    """The BLAKE2 of parts, each with its length. Without processor support, SHA-256 takes twice as long."""
    total = hashlib.blake2b(digest_size=32)
    for part in parts:
        total.update(len(part).to_bytes(8, "little"))
        total.update(part)
    return total.hexdigest()


def encoded(value: object) -> bytes:
    """A document or a part of it as bytes, for a digest."""
    try:
        return msgspec.msgpack.encode(value)
    except OverflowError:  # a whole number of more than 64 bits
        return msgspec.json.encode(value)


class Output:
    """A folder that is replaced when the block ends without an exception.

    Args:
        out: the folder.
        base: a digest of what all drafts depend on.

    Raises:
        BenchError: ``out`` exists, is not empty, and was not written by an earlier build.
    """

    def __init__(self, out: Path, base: str) -> None:
        if out.exists() and not (out / MARK).is_file() and not (out.is_dir() and not any(out.iterdir())):
            raise BenchError(
                "not-a-site",
                "It exists and does not contain a built site.",
                where=str(out),
                hint="Name a new or empty folder with --out.",
            )
        self.out = out
        self.base = base
        self.before = _digests(out / MARK)
        self.digests: dict[str, list[str]] = {}
        self.written = 0

    def __enter__(self) -> Self:
        self.out.parent.mkdir(parents=True, exist_ok=True)
        self._scratch = tempfile.TemporaryDirectory(prefix=f".{self.out.name}.", dir=self.out.parent)
        self.new = Path(self._scratch.name) / "new"
        self.new.mkdir()
        self._folders = set[Path]()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._scratch:
            if error is None:
                state = json.dumps(self.digests, indent=0, sort_keys=True)
                (self.new / MARK).write_text(state + "\n", encoding="utf-8")
                replace_folder(self.out, self.new)

    def add(self, path: str, content: bytes) -> None:
        """Writes a file, or links the old one if it has this content."""
        if not self._link(path, digest(content)):
            self._write(path, content, "")

    def add_draft(self, path: str, inputs: bytes, write: Callable[[], str]) -> None:
        """Writes a file, or links the old one if it was made from the same inputs and is unchanged."""
        source = digest(self.base.encode(), inputs)
        old = self.before.get(path)
        if old is not None and old[0] == source and self._link(path, old[1]):
            self.digests[path] = old
        else:
            self._write(path, write().encode(), source)

    def _write(self, path: str, content: bytes, source: str) -> None:
        target = self._target(path)
        target.write_bytes(content)
        self.written += 1
        if source:
            self.digests[path] = [source, digest(content)]

    def _link(self, path: str, expected: str) -> bool:
        old = self.out / path
        try:
            if digest(old.read_bytes()) != expected:
                return False
            target = self._target(path)
            try:
                os.link(old, target)
            except OSError:  # a file system without links
                shutil.copyfile(old, target)
        except OSError:
            return False
        return True

    def _target(self, path: str) -> Path:
        target = self.new / path
        if target.parent not in self._folders:
            target.parent.mkdir(parents=True, exist_ok=True)
            self._folders.add(target.parent)
        return target


def _digests(mark: Path) -> dict[str, list[str]]:
    """The digests of an earlier build; none where its mark is missing, old or damaged."""
    try:
        state = json.loads(mark.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(state, dict):
        return {}
    return {
        path: pair
        for path, pair in state.items()
        if isinstance(pair, list) and len(pair) == 2 and all(isinstance(part, str) for part in pair)
    }
