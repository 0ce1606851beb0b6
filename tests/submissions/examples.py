"""Examples of submissions that break a rule: a change of a valid submission, and the expected problems."""

import hashlib
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gym_extensions.submissions.problem import Problem

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
    group: str = GROUP
    count: int = 1
    """The number of problems of the rule."""


def found(problems: tuple[Problem, ...]) -> list[tuple[str, str]]:
    """Where and rule of each problem."""
    return [(problem.where, problem.rule) for problem in problems]


def rules(problems: tuple[Problem, ...]) -> list[str]:
    """The rule of each problem."""
    return [problem.rule for problem in problems]


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


def row(number: int, change_cells: Callable[[list[str]], list[str]], path: str = LOG) -> Change:
    """Changes the cells of a row (the header is row 1)."""

    def change(folder: Path) -> None:
        lines = (folder / path).read_text().split("\n")
        lines[number - 1] = ",".join(change_cells(lines[number - 1].split(",")))
        (folder / path).write_text("\n".join(lines), newline="\n")

    return change


def cell(number: int, column: int, value: str, path: str = LOG) -> Change:
    """Writes another value into one cell."""
    return row(number, lambda cells: [*cells[:column], value, *cells[column + 1 :]], path)


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
