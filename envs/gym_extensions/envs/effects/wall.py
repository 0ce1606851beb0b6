"""The wall, whose x is drawn at reset."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.obstacles import Wall
from gym_extensions.envs.effects.base import Effect, EffectKind, VectorEffect, required
from gym_extensions.envs.protocols import Array, Generators, Indices, Physics, Simulation, Template


class WallEffect(Effect):
    """Places the wall in one environment. A parked wall stays at its position in the model."""

    def __init__(self, task: Task) -> None:
        self._wall = required(task, Wall)

    def on_reset(self, simulation: Simulation) -> None:
        """Places the wall's center at an x from U(nearest, farthest)."""
        wall = self._wall
        if not wall.parked:
            x = simulation.np_random.uniform(wall.nearest, wall.farthest)
            simulation.data.mocap_pos[0] = (x, 0.0, wall.centre_height)


class VectorWallEffect(VectorEffect):
    """Places the walls of many environments."""

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._walls = [required(template.task, Wall) for template in templates]

    def draw(self, indices: Indices, generators: Generators, rows: dict[str, Array]) -> None:
        """Adds ``mocap_pos``, the walls' centers."""
        centers = np.zeros((len(indices), 1, 3))
        for row, (index, generator) in enumerate(zip(indices, generators, strict=True)):
            wall = self._walls[index]
            centers[row, 0] = wall.rest
            if not wall.parked:
                centers[row, 0, 0] = generator.uniform(wall.nearest, wall.farthest)
        rows["mocap_pos"] = centers


KIND = EffectKind(Wall, WallEffect, VectorWallEffect, draw_order=1, shard_key=lambda wall: wall.half_sizes)
