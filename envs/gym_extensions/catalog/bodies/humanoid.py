"""The humanoid bodies, which run, stand up, or do both."""

from __future__ import annotations

from gym_extensions.catalog.bodies.body import (
    TIME_LIMIT_ONLY,
    Body,
    Camera,
    Feet,
    Prose,
    RewardBounds,
    gymnasium_source,
    uniform_start,
)
from gym_extensions.catalog.bodies.success import Height

COSTS = "0.1·Σ ctrl² − min(5e-7·Σ cfrc_ext², 10)"
WALL_WIDTH = 10.0
"""In m: a humanoid would walk around a narrower wall."""
LYING_CAMERA = Camera(0.4, 0.2, 3.0, 110, -20)
STANDING = Height(
    1.0,
    2.0,
    "At the last step, the height of the torso is in (1, 2) m, where Humanoid counts as healthy.",
)
FEET = Feet(("right_foot", "left_foot"), distance=0.18)
PARTS = {
    "Torso": ("torso1", "uwaist", "lwaist"),
    "Thigh": ("right_thigh1", "left_thigh1", "butt"),
    "Leg": ("right_shin1", "left_shin1"),
    "Foot": FEET.names,
    "Head": ("head",),
    "Arm": ("right_uarm1", "right_larm", "left_uarm1", "left_larm"),
    "Hand": ("right_hand", "left_hand"),
}

HUMANOIDS = (
    Body(
        name="Humanoid",
        family="humanoid",
        asset="humanoid.xml",
        model_name="humanoid",
        prose=Prose(
            "A three-dimensional two-legged body with arms that walks forward.",
            f"1.25·Δx/dt + 5 while healthy − {COSTS}. Δx is that of the center of mass, dt = 0.015 s.",
            uniform_start("Humanoid", "0.01"),
            "Unhealthy: height of the torso outside (1, 2) m.",
            gymnasium_source("humanoid_v5"),
        ),
        rewards=RewardBounds(-50.0, 50.0),  # 5 for health, 1.25 × speed in m/s, contact cost at most 10
        camera=Camera(0.0, 0.85, 3.0, 120, -8),
        parts=PARTS,
        feet=FEET,
        beams="torso",
        wall_width=WALL_WIDTH,
    ),
    Body(
        name="HumanoidStandup",
        family="humanoid",
        asset="humanoidstandup.xml",
        model_name="humanoidstandup",
        prose=Prose(
            "A humanoid lying on its back that stands up.",
            f"z/0.003 + 1 − {COSTS}. z is the height of the torso.",
            uniform_start("HumanoidStandup", "0.01"),
            TIME_LIMIT_ONLY,
            gymnasium_source("humanoidstandup_v5"),
        ),
        rewards=RewardBounds(-100.0, 1500.0, terminates=False),  # height / 0.003 s: 1 m gives 333
        camera=LYING_CAMERA,
        success=STANDING,
        parts=PARTS,
        feet=FEET,
        beams="world",
        wall_width=WALL_WIDTH,
    ),
    Body(
        name="HumanoidStandupAndRun",
        family="humanoid",
        asset="humanoidstandup.xml",
        model_name="humanoidstandup",
        prose=Prose(
            "A humanoid lying on its back that stands up and runs.",
            f"1.25·Δx/dt + z/0.003 + (5 if 1 < z < 2, else 1) − {COSTS}. Δx is that of the center of mass, "
            "z the height of the torso, dt = 0.015 s.",
            uniform_start("HumanoidStandup", "0.01"),
            TIME_LIMIT_ONLY,
            "The paper's task, on Gymnasium's `humanoidstandup.xml` with Humanoid-v5's observation.",
        ),
        rewards=RewardBounds(-200.0, 1600.0, terminates=False),  # the sum of the two above
        camera=LYING_CAMERA,
        success=STANDING,
        parts=PARTS,
        feet=FEET,
        beams="world",
        wall_width=WALL_WIDTH,
    ),
)
