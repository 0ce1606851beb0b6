"""A log's bytes as columns of text, cut without interpreting them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Text:
    """The bytes of one CSV file: its path inside the submission and the header that it must have."""

    path: str
    header: tuple[str, ...]
    data: bytes


def columns(text: Text) -> dict[str, list[str]]:
    """Each column's cells by its name; only for bytes in which no rule found a problem."""
    width = len(text.header)
    cells = text.data[text.data.index(b"\n") + 1 : -1].decode("ascii").replace("\n", ",").split(",")
    return {name: cells[place::width] for place, name in enumerate(text.header)}
