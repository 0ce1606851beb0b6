"""What a broken folder is: a good one, a way to spoil it, and every word that is then told."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

GROUP = "hopper-gravity"
TOML = "submission.toml"
LOG = f"{GROUP}/sequential.csv"
TRACE = f"{GROUP}/traces/sequential-run0-stage1-HopperGravityHalf-episode3.npz"
HALF = "gym_extensions/HopperGravityHalf-v0"

Good = Callable[[str, Path], Path]
"""Copies the good submission of a group into a folder."""
Spoil = Callable[[Path], object]


@dataclass(frozen=True)
class Broken:
    """A folder with a mistake: which rule it breaks, how it is broken, and what is told, whole."""

    rule: str
    title: str
    spoil: Spoil
    told: tuple[tuple[str, str, str], ...]
    """Where, what was found, what to do."""
    also: tuple[str, ...] = ()
    """Other rules that the same mistake breaks."""
    group: str = GROUP


Judge = Callable[[Broken], None]
"""Spoils a good folder and looks at what is told."""


def each(examples: tuple[Broken, ...]) -> pytest.MarkDecorator:
    """A test for each example, called by its rule and title."""
    return pytest.mark.parametrize("example", examples, ids=lambda one: f"{one.rule}: {one.title}")


def edit(old: str, new: str, path: str = LOG, count: int = 1) -> Spoil:
    """Replaces a text that is there."""

    def spoil(folder: Path) -> None:
        text = (folder / path).read_bytes().decode()
        assert old in text
        (folder / path).write_bytes(text.replace(old, new, count).encode())

    return spoil


def all_of(*spoils: Spoil) -> Spoil:
    """Spoils in several ways."""

    def spoil(folder: Path) -> None:
        for each in spoils:
            each(folder)

    return spoil


def row(number: int, change: Callable[[list[str]], list[str]], path: str = LOG) -> Spoil:
    """Changes the cells of the row of that number (the header is row 1)."""

    def spoil(folder: Path) -> None:
        lines = (folder / path).read_text().split("\n")
        lines[number - 1] = ",".join(change(lines[number - 1].split(",")))
        (folder / path).write_text("\n".join(lines), newline="\n")

    return spoil


def cell(number: int, column: int, value: str, path: str = LOG) -> Spoil:
    """Writes another value into one cell."""
    return row(number, lambda cells: [*cells[:column], value, *cells[column + 1 :]], path)


def lines(change: Callable[[list[str]], list[str]], path: str = LOG) -> Spoil:
    """Changes the list of data lines."""

    def spoil(folder: Path) -> None:
        text = (folder / path).read_text().split("\n")
        (folder / path).write_text("\n".join([text[0], *change(text[1:-1]), ""]), newline="\n")

    return spoil


def put(path: str, data: bytes) -> Spoil:
    """Writes a file."""

    def spoil(folder: Path) -> None:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)

    return spoil


def remove(path: str) -> Spoil:
    """Removes a file."""
    return lambda folder: (folder / path).unlink()


def arrays(**content: object) -> bytes:
    """An .npz file of these arrays."""
    stream = io.BytesIO()
    np.savez(stream, **content)  # type: ignore[arg-type]
    return stream.getvalue()
