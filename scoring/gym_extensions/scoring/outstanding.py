"""What stands out in a scorecard, in a sentence each: what is forgotten, helped and hurt most."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Document = dict[str, Any]

FORGETS = ("forgets {} most: {} → {}", "after_env_training", "fully_trained")
HELPED = ("earlier tasks help {} most: {} alone, {} after them", "single_env", "after_env_training")
HURT = ("earlier tasks hurt {} most: {} alone, {} after them", "single_env", "after_env_training")


def _name(row: Document) -> str:
    return str(row["task"]).rsplit("/", 1)[-1].rsplit("-v", 1)[0]


def _most(scored: Document, rows: Sequence[Document], columns: tuple[str, str], sign: int) -> Document | None:
    """The row with the largest rise (sign 1) or fall (sign -1) between two columns; None where there is none.

    Differences are in the task's span from floor to ceiling; tasks without one count only where no task has
    one.
    """
    first, second = columns
    whole = [row for row in rows if row[first] and row[second]]
    spans = {row["task"]: scored["reference"][row["task"]] for row in whole}
    normal = [row for row in whole if spans[row["task"]]["ceiling"] is not None]

    def rise(row: Document) -> float:
        span = spans[row["task"]]
        height = span["ceiling"] - span["floor"] if normal else 1.0
        difference: float = sign * (row[second]["mean"] - row[first]["mean"]) / height
        return difference

    best = max(normal or whole, key=rise, default=None)
    return best if best is not None and rise(best) > 0 else None


def outstanding(scored: Document) -> list[str]:
    """Sentences on one group of a scorecard that has the paper's table; none where nothing stands out."""
    rows = scored.get("table", [])
    told = []
    for (sentence, first, second), part, sign in (
        (FORGETS, rows[:-1], -1),
        (HELPED, rows[1:], 1),
        (HURT, rows[1:], -1),
    ):
        row = _most(scored, part, (first, second), sign)
        if row is not None:
            told.append(
                sentence.format(_name(row), f"{row[first]['mean']:.0f}", f"{row[second]['mean']:.0f}")
            )
    opened = [_name(row) for row in rows if scored["reference"][row["task"]]["open"]]
    if opened:
        told.append(f"no reference agent has learned {', '.join(opened)}: in no normalised mean")
    return told
