"""Makes attacks that change the log or the manifest and nothing else: rules stop them without a replay."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..forger import Forger, Row, cells
from ..judge import Make
from ..workshop import Workshop


def log_only(edit: Callable[[Row], object]) -> Make:
    """Changes rows, and leaves everything else."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        forger.change(edit)
        return forger.folder

    return make


def first_row(**values: str) -> Make:
    """Changes cells of the first row."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        rows = forger.rows()
        rows[0] |= values
        forger.write(rows)
        return forger.folder

    return make


def fewer(workshop: Workshop) -> Path:
    """Leaves the five worst episodes of every cell out."""
    forger = Forger(workshop.copy("random"))
    rows = []
    for cell in cells(forger.rows()):
        worst = sorted(cell, key=lambda row: float(row["return"]))[:5]
        rows += [row for row in cell if row not in worst]
    forger.write(rows)
    return forger.commit()


def other_root(workshop: Workshop) -> Path:
    forger = Forger(workshop.copy("random"))
    forger.declare("root", f'"{"5a" * 32}"')
    return forger.folder
