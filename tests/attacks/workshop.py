"""Where attacks are made: honest submissions with the traces of all episodes, and copies of them."""

from __future__ import annotations

import itertools
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

Recorder = Callable[[Path], object]
"""Records an honest submission into a folder."""


class Workshop:
    """A folder with honest submissions, which are recorded when they are first needed, and copies of them.

    Args:
        root: the folder.
        recorders: how each honest submission is recorded, by name.
    """

    def __init__(self, root: Path, recorders: Mapping[str, Recorder]) -> None:
        self._root, self._recorders = root, recorders
        self._numbers = itertools.count()
        self._attacks = root / "attacks" / str(os.getpid())

    def honest(self, name: str) -> Path:
        """The honest submission of that name. It must not be changed."""
        folder = self._root / "honest" / name
        if not folder.exists():
            partial = self._root / "partial" / f"{name}-{os.getpid()}"
            shutil.rmtree(partial, ignore_errors=True)
            self._recorders[name](partial)
            folder.parent.mkdir(parents=True, exist_ok=True)
            if not folder.exists():  # another process may have been quicker
                partial.rename(folder)
        return folder

    def empty(self) -> Path:
        """A new empty folder."""
        folder = self._attacks / str(next(self._numbers))
        folder.mkdir(parents=True)
        return folder

    def copy(self, name: str, entry: str = "attack") -> Path:
        """A copy of an honest submission that can be changed; its traces are links, which are replaced."""
        return Path(shutil.copytree(self.honest(name), self.empty() / entry, copy_function=link_arrays))

    def clear(self) -> None:
        """Removes the attacks of this process."""
        shutil.rmtree(self._attacks, ignore_errors=True)


def link_arrays(source: str, target: str) -> None:
    """Links an .npz file, and copies any other."""
    if source.endswith(".npz"):
        os.link(source, target)
    else:
        shutil.copy2(source, target)


def put(path: Path, data: bytes) -> None:
    """Writes a file anew, so that a link to it elsewhere keeps its content."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    path.write_bytes(data)
