"""The rule by which the ten maps and their goals were drawn. It gives the committed files byte for byte.

It is the rule of 2017 on cells (Henderson et al. 2017's code): rectangles ~ Poisson(92), center uniform, 1–3
cells wide and 1–5 high, dropped if they would leave the map; the outermost ring is solid; pockets that are
not joined by edges to the largest free region are filled. The map's number is the seed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from gym_extensions.catalog.tasks import GOALS, MAPS
from gym_extensions.envs.navigation.geometry import CELL, COLUMNS, ROWS

RECTANGLES = 92
MOST_WIDE, MOST_HIGH = 3, 5
GOAL_CLEARANCE = 20.0
"""Smallest distance of a goal's center from every obstacle, the border among them, in units."""
GOAL_SPACING = 150.0
"""Smallest distance between two goals of a map, in units."""


def draw_cells(generator: np.random.Generator) -> NDArray[np.bool_]:
    """The obstacles of a new map, shape (48, 64), row 0 at the bottom."""
    cells = np.zeros((ROWS, COLUMNS), dtype=bool)
    cells[[0, -1], :] = cells[:, [0, -1]] = True
    for _ in range(generator.poisson(RECTANGLES)):
        width, height = (
            generator.integers(1, MOST_WIDE, endpoint=True),
            generator.integers(1, MOST_HIGH, endpoint=True),
        )
        left = round(generator.uniform(0, COLUMNS) - width / 2)
        bottom = round(generator.uniform(0, ROWS) - height / 2)
        if left >= 0 and bottom >= 0 and left + width <= COLUMNS and bottom + height <= ROWS:
            cells[bottom : bottom + height, left : left + width] = True
    regions, _ = ndimage.label(~cells)
    largest = np.bincount(regions[regions > 0]).argmax()
    return np.asarray(regions != largest)


def clearances(cells: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The distance in units from each cell's center to the closest edge of an obstacle, 0 in an obstacle."""
    gaps = np.abs(np.argwhere(np.ones_like(cells))[:, None] - np.argwhere(cells)[None]) * CELL - CELL / 2
    return np.asarray(np.hypot(*np.maximum(gaps, 0.0).transpose(2, 0, 1)).min(axis=1).reshape(cells.shape))


def draw_goals(cells: NDArray[np.bool_], generator: np.random.Generator) -> list[tuple[float, float]]:
    """Three cell centers, drawn one at a time, far enough from obstacles and from each other."""
    rows, columns = np.nonzero(clearances(cells) >= GOAL_CLEARANCE)
    centers = (np.column_stack([columns, rows]) + 0.5) * CELL
    while True:
        candidates, drawn = centers, list[tuple[float, float]]()
        while len(candidates) and len(drawn) < len(GOALS):
            x, y = candidates[generator.integers(len(candidates))]
            drawn.append((float(x), float(y)))
            candidates = candidates[np.hypot(candidates[:, 0] - x, candidates[:, 1] - y) >= GOAL_SPACING]
        if len(drawn) == len(GOALS):
            return drawn


def drawn_files() -> dict[str, str]:
    """The text of every file in ``maps``, by its name."""
    texts, rows = {}, ["map,goal,x,y"]
    for number in MAPS:
        generator = np.random.default_rng(number)
        cells = draw_cells(generator)
        lines = ["".join("#" if cell else "." for cell in row) for row in cells[::-1]]
        texts[f"map{number}.txt"] = "\n".join(lines) + "\n"
        for goal, (x, y) in enumerate(draw_goals(cells, generator)):
            rows.append(f"{number},{goal},{x:g},{y:g}")
    return texts | {"goals.csv": "\n".join(rows) + "\n"}
