"""How strongly a cell of an evaluation matrix is tinted."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gym_extensions.scoring.scorecard.model import ReferenceValue
from gym_extensions.site.text.numbers import digits_for
from gym_extensions.site.views.trial import Trial

Matrix = Sequence[Sequence[float]]
STEPS = 10


def tint(value: float, reference: ReferenceValue | None) -> str:
    """A class of the style sheet: ``h0`` (floor) … ``h10`` (reference or above), ``below``, ``unsolved``."""
    share = reference.normalize(value) if reference else None
    if share is None:
        return "unsolved"
    level = math.floor(share * STEPS + 0.5)
    return "below" if level < 0 else f"h{min(level, STEPS)}"


def mean(matrices: Sequence[Matrix]) -> tuple[tuple[float, ...], ...]:
    """The mean over runs, cell by cell."""
    return tuple(
        tuple(math.fsum(cells) / len(cells) for cells in zip(*stages, strict=True))
        for stages in zip(*matrices, strict=True)
    )


def digits(trial: Trial) -> int:
    """Digits after the point for all matrices of a trial: none where returns reach the hundreds."""
    stages = (*trial.final_returns, *(stage for run in trial.stage_matrices for stage in run))
    cells = (cell for stage in stages for cell in stage)
    return digits_for(10 * cell for cell in cells)
