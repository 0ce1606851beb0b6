"""The tint of a cell in an evaluation matrix."""

from __future__ import annotations

import math

from gym_extensions.scoring.scorecard.model import ReferenceValue

STEPS = 10


def tint(value: float, reference: ReferenceValue | None) -> str:
    """A class of the style sheet: ``h0`` (floor) … ``h10`` (reference or above), ``below``, ``unsolved``."""
    share = reference.normalize(value) if reference else None
    if share is None:
        return "unsolved"
    level = math.floor(share * STEPS + 0.5)
    return "below" if level < 0 else f"h{min(level, STEPS)}"
