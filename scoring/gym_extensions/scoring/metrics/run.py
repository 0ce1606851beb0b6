"""One run in normalised returns: what every metric is a function of, with the indices of the formulas."""

from __future__ import annotations

from dataclasses import dataclass, field


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
