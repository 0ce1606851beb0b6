"""The tables of returns: their cells and tints."""

import math
from collections.abc import Sequence

from markupsafe import Markup

from gym_extensions.scoring.scorecard import ReferenceValue, TaskChange
from gym_extensions.site.submission_results import SubmissionResult
from gym_extensions.site.text import fixed, variation

STEPS = 10
MAX_CELLS = 3_000
"""Cells of all runs' matrices on one page; those of larger groups are in the data alone."""
CHANGE_STEPS = 5
LARGEST_CHANGE = 1.0
"""The change with the strongest tint: the whole distance from floor to expert."""


def tint(value: float, reference: ReferenceValue | None, top: float = 1.0) -> str:
    """A class of the style sheet for a raw return: ``h0`` (floor) … ``h10``, ``below`` or ``open``.

    ``top`` is the score with the strongest tint, the highest of the matrix or 1 if that is higher.
    """
    share = reference.normalize(value) if reference else None
    if share is None:
        return "open"
    level = math.floor(share / top * STEPS + 0.5)
    return "below" if level < 0 else f"h{min(level, STEPS)}"


def tinted(rows: Sequence[Sequence[float]], result: SubmissionResult) -> list[list[tuple[str, str]]]:
    """The cells of a matrix ``[row][task]`` of raw returns: tint and text of each."""
    top, digits = result.detail.top_score, result.matrix_digits
    references = [result.detail.reference.get(task) for task in result.tasks]
    return [
        [(tint(value, each, top), fixed(value, digits)) for value, each in zip(row, references, strict=True)]
        for row in rows
    ]


def stage_rows(cells: Sequence[Sequence[float]], result: SubmissionResult) -> Markup:
    """The rows of a matrix ``[stage][task]``, each with the task that was trained last; that cell is marked.

    They are written here, because a large site has millions of cells and a template needs longer for each.
    """
    titles = [variation(task, result.tasks) for task in result.tasks]
    rows = []
    for stage, row in enumerate(tinted(cells, result)):
        title = f"{stage} {titles[stage - 1]}" if stage else "no training"
        body = "".join(
            f'<td class="{kind}{" trained" if at == stage else ""}">{text}'
            for at, (kind, text) in enumerate(row, 1)
        )
        rows.append(f'<tr><th scope="row">{title}</th>\n{body}</tr>\n')
    return Markup("".join(rows))


def shows_each_run(result: SubmissionResult) -> bool:
    """Whether the page has the matrix of every run: at most some thousand cells, or it would be too large."""
    return len(result.runs) * len(result.tasks) ** 2 <= MAX_CELLS


def change_tint(change: TaskChange) -> str:
    """Classes of the style sheet: ``lost1`` … ``lost5``, ``kept``, ``won1`` … ``won5``.

    It is ``raw`` without an expert. ``unsure`` is added where the interval contains 0 or there is none.
    """
    unsure = "" if change.is_certain else " unsure"
    mean = change.mean
    if mean is None or not change.normalized:
        return f"raw{unsure}"
    level = min(CHANGE_STEPS, math.floor(abs(mean) / LARGEST_CHANGE * CHANGE_STEPS + 0.5))
    kind = "kept" if level == 0 else f"{'lost' if mean < 0 else 'won'}{level}"
    return kind + unsure
