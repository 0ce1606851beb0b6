"""Files of a submission that are written to a temporary folder and then moved into place together."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gym_extensions.rollouts.layout import PROGRESS


@contextmanager
def staging(out: Path) -> Iterator[Path]:
    """An empty folder in the submission's progress. It is deleted at the end, also after an error.

    Only the process that holds the submission's write lock may use it.
    """
    folder = out / PROGRESS / "staged"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def move_into_place(staged: Path, out: Path, last: Path) -> None:
    """Moves every file of ``staged`` to the same path in ``out``. Renaming needs no disk space.

    Args:
        staged: a folder on the same file system as ``out``.
        out: the submission's folder.
        last: the path of the file that is moved last, relative to both.
    """
    files = sorted(path.relative_to(staged) for path in staged.rglob("*") if path.is_file())
    for file in sorted(files, key=lambda file: file == last):
        (out / file).parent.mkdir(parents=True, exist_ok=True)
        (staged / file).replace(out / file)
