"""The tint of a cell in an evaluation matrix, and of a change in a retention map."""

from __future__ import annotations

import math
from collections.abc import Sequence

from markupsafe import Markup

from gym_extensions.scoring.scorecard.model import ReferenceValue
from gym_extensions.site.text.names import variation
from gym_extensions.site.text.numbers import fixed
from gym_extensions.site.views.retention import Change
from gym_extensions.site.views.trial import Trial

STEPS = 10
CHANGE_STEPS = 5
LARGEST_CHANGE = 1.0
"""The change with the strongest tint: the whole distance from floor to reference."""


def tint(value: float, reference: ReferenceValue | None, top: float = 1.0) -> str:
    """A class of the style sheet: ``h0`` (floor) … ``h10``, ``below`` or ``unsolved``.

    Args:
        value: a raw return.
        reference: floor and ceiling of the task.
        top: the score with the strongest tint, the highest of the matrix or 1 if that is higher.
    """
    share = reference.normalize(value) if reference else None
    if share is None:
        return "unsolved"
    level = math.floor(share / top * STEPS + 0.5)
    return "below" if level < 0 else f"h{min(level, STEPS)}"


def tinted(rows: Sequence[Sequence[float]], trial: Trial) -> list[list[tuple[str, str]]]:
    """The cells of a matrix ``[row][task]`` of raw returns: tint and text of each."""
    columns = [(trial.reference(task), trial.top_score, trial.matrix_digits) for task in trial.tasks]
    return [
        [
            (tint(value, reference, top), fixed(value, digits))
            for value, (reference, top, digits) in zip(row, columns, strict=True)
        ]
        for row in rows
    ]


def stage_rows(cells: Sequence[Sequence[float]], trial: Trial) -> Markup:
    """The rows of a matrix ``[stage][task]``, each with the task that was trained last; that cell is marked.

    They are written here, because a large site has millions of cells and a template needs longer for each.
    """
    titles = [variation(task, trial.tasks) for task in trial.tasks]
    rows = []
    for stage, row in enumerate(tinted(cells, trial)):
        title = f"{stage} {titles[stage - 1]}" if stage else "no training"
        body = "".join(
            f'<td class="{kind}{" trained" if at == stage else ""}">{text}</td>'
            for at, (kind, text) in enumerate(row, 1)
        )
        rows.append(f'<tr><th scope="row">{title}</th>\n{body}</tr>\n')
    return Markup("".join(rows))


def change_tint(change: Change) -> str:
    """Classes of the style sheet: ``lost1`` … ``lost5``, ``kept``, ``won1`` … ``won5``.

    It is ``raw`` without a ceiling. ``unsure`` is added where the interval contains 0 or there is none.
    """
    unsure = "" if change.is_certain else " unsure"
    mean = change.value.mean
    if mean is None or not change.normalized:
        return f"raw{unsure}"
    level = min(CHANGE_STEPS, math.floor(abs(mean) / LARGEST_CHANGE * CHANGE_STEPS + 0.5))
    kind = "kept" if level == 0 else f"{'lost' if mean < 0 else 'won'}{level}"
    return kind + unsure
