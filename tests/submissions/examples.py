"""Examples of submissions that break a rule: a change of a valid submission, and the expected problems."""

import hashlib
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

GROUP = "hopper-gravity"
TOML = "submission.toml"
LOG = f"{GROUP}/sequential/run0.csv"
DOCUMENT = f"{GROUP}/sequential/run0.json"
POLICIES = f"{GROUP}/sequential/run0.npz"
HALF = "gym_extensions/HopperGravityHalf-v0"

CopySubmission = Callable[[str, Path], Path]
"""Copies the valid submission of a group into a folder."""
Change = Callable[[Path], object]
"""Changes the files of a submission."""


@dataclass(frozen=True)
class Example:
    """A submission with a mistake: the rule that it breaks, and what its first problem says."""

    rule: str
    title: str
    change: Change
    where: str
    """Where the first problem of the rule is."""
    fact: str
    """What its message or hint contains."""
    also: tuple[str, ...] = ()
    """Other rules that the same mistake breaks."""
    count: int = 1
    """The number of problems of the rule."""
    group: str = GROUP


Table = dict[str, list[tuple[Any, ...]]]
"""By rule: the other fields of each example."""


def edit(old: str, new: str, path: str = LOG, count: int = 1) -> Change:
    """Replaces a text that the file contains."""

    def change(folder: Path) -> None:
        text = (folder / path).read_bytes().decode()
        assert old in text
        (folder / path).write_bytes(text.replace(old, new, count).encode())

    return change


def all_of(*changes: Change) -> Change:
    """Makes several changes in order."""

    def change(folder: Path) -> None:
        for step in changes:
            step(folder)

    return change


def cell(number: int, column: int, value: str, path: str = LOG) -> Change:
    """Writes another value into one cell (the header is row 1)."""

    def change(folder: Path) -> None:
        rows = [line.split(",") for line in (folder / path).read_text().split("\n")]
        rows[number - 1][column] = value
        (folder / path).write_text("\n".join(map(",".join, rows)), newline="\n")

    return change


def lines(change_rows: Callable[[list[str]], list[str]], path: str = LOG) -> Change:
    """Changes the list of data rows."""

    def change(folder: Path) -> None:
        text = (folder / path).read_text().split("\n")
        (folder / path).write_text("\n".join([text[0], *change_rows(text[1:-1]), ""]), newline="\n")

    return change


def put(path: str, data: bytes) -> Change:
    """Writes a file."""

    def change(folder: Path) -> None:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)

    return change


def document(path: str = DOCUMENT, **changes: object) -> Change:
    """Changes keys of a run's document; ``memory__stored_steps`` is a key of ``memory``."""

    def change(folder: Path) -> None:
        content = json.loads((folder / path).read_text())
        for name, value in changes.items():
            *outer, last = name.split("__")
            table = content
            for part in outer:
                table = table[part]
            table[last] = value
        (folder / path).write_text(json.dumps(content))

    return change


def redigest(change: Change, path: str = LOG) -> Change:
    """Makes a change of a log and states the new digest in its document."""

    def changed(folder: Path) -> None:
        change(folder)
        digest = hashlib.sha256((folder / path).read_bytes()).hexdigest()
        document(path.replace(".csv", ".json"), log=digest)(folder)

    return changed


def remove(path: str) -> Change:
    """Removes a file."""
    return lambda folder: (folder / path).unlink()


def arrays(**content: object) -> bytes:
    """An .npz file of these arrays. Arrays of objects are pickled, as in a hostile file."""
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=True, **{name: np.asarray(values) for name, values in content.items()})
    return stream.getvalue()
