"""The five observation families, with the meaning of each entry and their spaces."""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box

from gym_extensions.envs.fields import Field
from gym_extensions.envs.navigation.grid import CELL, HEIGHT, WIDTH
from gym_extensions.envs.navigation.motion import MAX_SPEED
from gym_extensions.envs.navigation.raycast import BEAMS, MAX_RANGE

PIXEL = 4.0
"""Side of a pixel of an image observation, in units."""


AGENT = (Field("x of the agent", "unit", 0.0, WIDTH), Field("y of the agent", "unit", 0.0, HEIGHT))
GOAL = (Field("x of the goal", "unit", 0.0, WIDTH), Field("y of the goal", "unit", 0.0, HEIGHT))
NEAREST = (
    # The border is solid, so the distance is at most half the inner height.
    Field("distance to the closest obstacle", "unit", 0.0, HEIGHT / 2 - CELL),
    Field("bearing to it, world frame, (−π, π]", "rad", -np.pi, np.pi),
)
RANGES = (
    Field(
        "range along beam i, at 22.5°·i in the world frame; 100 without a hit", "unit", 0.0, MAX_RANGE, BEAMS
    ),
)

FIELDS: dict[str, tuple[Field, ...]] = {
    "state": AGENT + NEAREST,
    "state-goal": AGENT + NEAREST + GOAL,
    "range": RANGES,
    "range-known": RANGES + AGENT + GOAL,
}
"""The entries of each family, in order; the family ``image`` is a picture."""


def observation_space(family: str) -> Box:
    """Returns the observation space of a family."""
    if family == "image":
        return Box(0, 255, (round(HEIGHT / PIXEL), round(WIDTH / PIXEL), 3), np.uint8)
    low = [field.low for field in FIELDS[family] for _ in range(field.count)]
    high = [field.high for field in FIELDS[family] for _ in range(field.count)]
    return Box(np.array(low, dtype=np.float32), np.array(high, dtype=np.float32), dtype=np.float32)


def action_space() -> Box:
    """Returns the action space, which is the displacement in x and in y in units per step."""
    return Box(-MAX_SPEED, MAX_SPEED, (2,), np.float32)
