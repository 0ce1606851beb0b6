"""The table of a board as CSV."""

from __future__ import annotations

import csv
import io

from gym_extensions.scoring.output.spreadsheet import no_formula
from gym_extensions.site.text import labels
from gym_extensions.site.views.board import Board

FACTS = (
    "entry",
    "title",
    "trust",
    "runs",
    "ranked",
    "task_label",
    "stored_transitions",
    "parameters",
    "algorithm",
    "authors",
    "accepted",
)


def board_csv(board: Board) -> str:
    """One row per entry from top to bottom: facts, then mean and interval per metric."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*FACTS, *(f"{name}{end}" for name in board.columns for end in ("", "_low", "_high"))])
    for row in board.rows:
        memory = row.entry.memory
        manifest = row.card.manifest
        facts = (
            row.entry.name,
            row.entry.title,
            row.entry.trust,
            row.runs,
            "true" if row.ranked else "false",
            labels.task_label(row.card),
            memory.stored_steps if memory else "",
            memory.parameters_last if memory else "",
            manifest.protocol.algorithm if manifest else "",
            "; ".join(row.entry.authors),
            row.entry.accepted,
        )
        values = [row.trial.metric(name) for name in board.columns]
        numbers = [number for value in values for number in (value.mean, value.low, value.high)]
        writer.writerow(
            [
                *(no_formula(fact) if isinstance(fact, str) else fact for fact in facts),
                *("" if number is None else repr(number) for number in numbers),
            ]
        )
    return out.getvalue()
