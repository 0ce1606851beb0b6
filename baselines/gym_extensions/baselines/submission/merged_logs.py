"""Joins the rows of evaluation logs and training curves by run. Rows stay as they are, byte for byte."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import TypeVar

from gym_extensions.errors import BenchError

Key = TypeVar("Key", bound=Hashable)


def merge_log(paths: Sequence[Path]) -> tuple[bytes, dict[int, Path]]:
    """The bytes of a log with the runs of all logs, sorted, and the first log that contains each run.

    Raises:
        BenchError: a run differs between two logs.
    """
    return _merge(paths, lambda cells: int(cells[0]), lambda run: f"Run {run}")


def merge_curves(paths: Sequence[Path]) -> bytes:
    """The bytes of a file with the training curves or evaluations of all files, sorted by protocol and run.

    Raises:
        BenchError: the curves of a run differ between two files.
    """
    content, _ = _merge(
        paths,
        lambda cells: (cells[0], int(cells[1])),
        lambda key: f"The {key[0]} curve of run {key[1]}",
    )
    return content


def _merge(
    paths: Sequence[Path], key_of: Callable[[list[str]], Key], describe: Callable[[Key], str]
) -> tuple[bytes, dict[Key, Path]]:
    owners: dict[Key, Path] = {}
    rows: dict[Key, list[str]] = {}
    header = ""
    for path in paths:
        header, *lines = path.read_text(encoding="ascii").splitlines()
        blocks: dict[Key, list[str]] = {}
        for line in lines:
            blocks.setdefault(key_of(line.split(",", 2)), []).append(line)
        for key, block in blocks.items():
            if rows.setdefault(key, block) != block:
                message = f"{describe(key)} differs from that in {owners[key]}."
                raise BenchError("different-run", message, str(path), "Leave it out of one of them.")
            owners.setdefault(key, path)
    ordered = sorted(rows, key=lambda key: key)  # type: ignore[arg-type,return-value]
    text = "\n".join([header, *(line for key in ordered for line in rows[key])]) + "\n"
    return text.encode(), {key: owners[key] for key in ordered}
