"""One run in normalised returns: what every metric is a function of, with the indices of the formulas."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

Number = float | None


def mean(values: Iterable[float]) -> Number:
    """The mean by ``math.fsum``; None of nothing, never 0."""
    listed = list(values)
    return math.fsum(listed) / len(listed) if listed else None


def deviation(values: Sequence[float], lost: int = 0, centre: float | None = None) -> float:
    """The standard deviation, dividing by n − ``lost`` (0: of these episodes, 1: of runs as a sample).

    ``centre`` is the values' mean, where it is known already.
    """
    centre = math.fsum(values) / len(values) if centre is None else centre
    gaps = [value - centre for value in values]
    return math.sqrt(math.fsum([gap * gap for gap in gaps]) / (len(values) - lost))


@dataclass(frozen=True)
class Run:
    """Normalised returns of one training seed; stages s count from 0 (untrained), tasks j from 1.

    ``scored`` are the positions j of the tasks that are not open. ``cells[s, j]`` is p[s][j], ``last[j]`` the
    normalised episodes at stage T, ``alone[j]`` p_single[j], ``area[j]``, ``area_alone[j]`` the areas
    under the training curves. All hold the scored positions only.
    """

    T: int
    scored: tuple[int, ...]
    cells: dict[tuple[int, int], float] = field(default_factory=dict)
    last: dict[int, tuple[float, ...]] = field(default_factory=dict)
    alone: dict[int, float] = field(default_factory=dict)
    area: dict[int, float] = field(default_factory=dict)
    area_alone: dict[int, float] = field(default_factory=dict)

    def p(self, s: int, j: int) -> float:
        """Normalised mean return on task j after stage s."""
        return self.cells[s, j]
