"""Writes the files of a site into a folder: only what changed, and all of it or nothing.

The new files are prepared in a hidden folder of the site, where files whose inputs did not change are linked,
and take the places of the old ones at the end. The folder itself stays, so it may be the current folder or a
mounted one. The file ``.gym-extensions-site`` marks a site, so that a build never replaces another folder,
and holds per path the digests of its inputs and of its content. Scorecards are kept in the hidden folder
``.scorecards``: scoring a submission takes half a second, reading its scorecard a few milliseconds.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import msgspec

from gym_extensions.errors import BenchError
from gym_extensions.scoring.pipeline import Scorer, scorecards
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.paths import slug

MARK = ".gym-extensions-site"
SCRATCH = ".gym-extensions-new-"
"""How the folder begins in which a site is prepared; what an interrupted build left is removed."""


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
    """A folder that gets the new files when the block ends without an exception.

    Args:
        out: the folder.
        base: a digest of what all drafts depend on.

    Raises:
        BenchError: ``out`` exists, is not empty, and was not written by an earlier build, or no folder can be
            made or written there.
    """

    def __init__(self, out: Path, base: str) -> None:
        hint = "Name a new or empty folder with --out."
        try:
            names = [path.name for path in out.iterdir()] if out.is_dir() else [""] * out.exists()
            if MARK not in names and not all(name.startswith(SCRATCH) for name in names):
                raise BenchError("not-a-site", "It exists and does not contain a built site.", str(out), hint)
            self._is_new = not out.exists()
            out.mkdir(parents=True, exist_ok=True)
            for left in out.glob(f"{SCRATCH}*"):
                shutil.rmtree(left)
            self._scratch = tempfile.TemporaryDirectory(prefix=SCRATCH, dir=out)
        except OSError as error:
            raise BenchError("no-folder", f"{error.strerror or error}.", str(out), hint) from error
        self.out = out
        self.base = base
        self.before = _digests(out / MARK)
        self.digests: dict[str, tuple[str, str]] = {}
        self.written = 0
        self.new, self._old = (Path(self._scratch.name) / name for name in ("new", "old"))
        self.new.mkdir()
        self._old.mkdir()
        self._folders = set[Path]()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._scratch:
            if error is None:
                state = json.dumps(self.digests, indent=0, sort_keys=True)
                (self.new / MARK).write_text(state + "\n", encoding="utf-8")
                self._swap()
        if error is not None and self._is_new:
            self.out.rmdir()

    def _swap(self) -> None:
        """Moves the old files away and the new ones in, the mark last; if that fails, everything back."""
        names = [path.name for path in self.out.iterdir() if not path.name.startswith(SCRATCH)]
        new = [path.name for path in self.new.iterdir() if path.name != MARK]
        moves = [(self.out / name, self._old / name) for name in names if name != MARK]
        moves += [(self.new / name, self.out / name) for name in (*new, MARK)]
        done = []
        try:
            for source, target in moves:
                source.replace(target)
                done.append((source, target))
        except BaseException:
            for source, target in reversed(done):
                target.replace(source)
            raise

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
            self.digests[path] = (source, digest(content))

    def _link(self, path: str, expected: str) -> bool:
        old = self.out / path
        try:
            if digest(old.read_bytes()) != expected:
                return False
            os.link(old, self._target(path))
        except OSError:
            return False
        return True

    def _target(self, path: str) -> Path:
        target = self.new / path
        if target.parent not in self._folders:
            target.parent.mkdir(parents=True, exist_ok=True)
            self._folders.add(target.parent)
        return target


def _digests(mark: Path) -> dict[str, tuple[str, str]]:
    """The digests of an earlier build; none where its mark is missing, old or damaged."""
    try:
        return msgspec.json.decode(mark.read_bytes(), type=dict[str, tuple[str, str]])
    except (OSError, ValueError):
        return {}


Kept = tuple[str, Scorecard]
"""The key of a scorecard (``folder_key``), and the scorecard."""


def kept_path(name: str) -> str:
    """The path in the site of the kept scorecard of a submission, a :data:`Kept` as ``encoded`` writes it."""
    return f".scorecards/{slug(name)}"


def folder_key(folder: Path, base: str) -> str:
    """The digest of all that the scorecard of a submission depends on: its files and ``base``.

    Empty for a folder with anything else than files and folders that can be read: it is always scored.
    """
    parts = [base.encode()]
    try:
        for path in sorted(folder.rglob("*")):
            if path.is_symlink() or not (path.is_file() or path.is_dir()):
                return ""
            parts.append(str(path.relative_to(folder)).encode("utf-8", "surrogateescape"))
            parts.append(path.read_bytes() if path.is_file() else b"")
    except OSError:
        return ""
    return digest(*parts)


def scorecards_since(
    out: Path, folders: Sequence[Path], keys: Mapping[str, str], scorer: Scorer
) -> Iterator[Scorecard]:
    """The scorecards of submissions in the order of their folders. Only changed ones are scored.

    ``out`` is the folder of the earlier site, and ``keys`` has the ``folder_key`` of each by its name.
    """

    def earlier(folder: Path) -> Scorecard | None:
        """The scorecard that an earlier build kept, if the files are the same; none of a refused one."""
        try:
            key, card = msgspec.msgpack.decode((out / kept_path(folder.name)).read_bytes(), type=Kept)
        except (OSError, ValueError):
            return None
        return card if key and key == keys[folder.name] and not card.problems else None

    changed = [folder for folder in folders if earlier(folder) is None]
    scored = scorecards(changed, scorer)
    is_changed = set(changed).__contains__
    return (next(scored) if is_changed(folder) else earlier(folder) or scorer(folder) for folder in folders)
