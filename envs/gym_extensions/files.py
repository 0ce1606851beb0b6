"""Atomic writes: a file is written completely or not at all, also if several processes write it at once."""

import os
import shutil
from pathlib import Path


def write_bytes(path: Path, content: bytes) -> None:
    """Writes to a temporary file of its own in the same folder, then renames it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.urandom(8).hex()}.partial")
    try:
        partial.write_bytes(content)
        partial.replace(path)
    except BaseException:  # a full disk, Ctrl-C
        partial.unlink(missing_ok=True)
        raise


def remove(path: Path) -> None:
    """Deletes a file, or a folder with all that is in it; nothing if there is none."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Writes a text file, UTF-8 with ``\\n``, whole or not at all."""
    write_bytes(path, text.encode())
