"""What stands out in a scorecard, in a sentence each: what is forgotten, helped and hurt most."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gym_extensions.scoring.statistics.intervals import interval

Document = dict[str, Any]

FORGETS = ("forgets {} most: {} → {}", "after_env_training", "fully_trained")
HELPED = ("earlier tasks help {} most: {} alone, {} after them", "single_env", "after_env_training")
HURT = ("earlier tasks hurt {} most: {} alone, {} after them", "single_env", "after_env_training")


def _name(row: Document) -> str:
    return str(row["task"]).rsplit("/", 1)[-1].rsplit("-v", 1)[0]


def _runs(scored: Document, alone: Document | None, place: int, column: str) -> list[float]:
    """One mean return a run behind a cell of the table; none of a published table."""
    if column == "single_env":
        return [means[place] for means in alone["matrix"]] if alone else []
    stage = {"fully_trained": -1, "after_env_training": place + 1}[column]
    return [means[stage][place] for means in scored["matrix"]]


def _clear(runs: Sequence[Sequence[float]], sign: int) -> bool:
    """Whether runs, before and after, rise (sign 1) or fall (sign -1) beyond chance; one cannot say no."""
    before, after = runs
    if min(len(before), len(after)) < 2:
        return True
    low = interval([sign * (b - a) for a, b in zip(before, after, strict=True)]).low
    return low is not None and low > 0


def outstanding(scored: Document, alone: Document | None = None) -> list[str]:
    """Sentences on one group of a scorecard that has the paper's table; none where nothing stands out.

    A difference is told where its 95 % interval over runs leaves out 0. The largest is chosen in the tasks'
    spans from floor to ceiling; tasks without one count only where no task has one.

    Args:
        scored: the group's sequential part.
        alone: its single part, if the entry has one.
    """
    rows = scored.get("table", [])
    references = [scored["reference"][row["task"]] for row in rows]
    spans = [
        known["ceiling"] - known["floor"] if known["ceiling"] is not None else None for known in references
    ]
    told = []
    for (sentence, first, second), places, sign in (
        (FORGETS, range(len(rows) - 1), -1),
        (HELPED, range(1, len(rows)), 1),
        (HURT, range(1, len(rows)), -1),
    ):
        whole = [place for place in places if rows[place][first] and rows[place][second]]
        normal = [place for place in whole if spans[place] is not None]
        rises = {
            place: sign * (rows[place][second]["mean"] - rows[place][first]["mean"]) / (spans[place] or 1.0)
            for place in normal or whole
            if _clear([_runs(scored, alone, place, column) for column in (first, second)], sign)
        }
        best = max(rises, key=rises.__getitem__, default=None)
        if best is not None and rises[best] > 0:
            means = (f"{rows[best][column]['mean']:.0f}" for column in (first, second))
            told.append(sentence.format(_name(rows[best]), *means))
    opened = [_name(row) for row, known in zip(rows, references, strict=True) if known["open"]]
    if opened:
        told.append(f"no reference agent has learned {', '.join(opened)}: in no normalised mean")
    return told
