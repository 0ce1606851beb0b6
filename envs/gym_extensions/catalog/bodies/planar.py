"""The three running bodies in the x–z plane."""

from __future__ import annotations

from gym_extensions.catalog.bodies.body import (
    TIME_LIMIT_ONLY,
    Body,
    Camera,
    Prose,
    RewardBounds,
    gymnasium_source,
    uniform_start,
)

PLANAR = (
    Body(
        name="Hopper",
        family="planar",
        asset="hopper.xml",
        model_name="hopper",
        prose=Prose(
            "A one-legged body in the x–z plane that hops forward.",
            "Δx/dt + 1 while healthy − 0.001·Σ a², with dt = 0.008 s.",
            uniform_start("Hopper", "0.005"),
            "Unhealthy: height ≤ 0.7 m, or |pitch| ≥ 0.2 rad, or another coordinate or velocity beyond ±100.",
            gymnasium_source("hopper_v5"),
        ),
        rewards=RewardBounds(-20.0, 20.0),  # 1 for health, plus the forward speed in m/s
        camera=Camera(0.0, 0.65, 2.6, 90, -8),
        parts={
            "Torso": ("torso_geom",),
            "Thigh": ("thigh_geom",),
            "Leg": ("leg_geom",),
            "Foot": ("foot_geom",),
        },
        beams="pitch",
        wall_width=0.8,
        velocity_limit=10.0,
    ),
    Body(
        name="Walker2d",
        family="planar",
        asset="walker2d_v5.xml",
        model_name="walker2d",
        prose=Prose(
            "A two-legged body in the x–z plane that walks forward.",
            "Δx/dt + 1 while healthy − 0.001·Σ a², with dt = 0.008 s.",
            uniform_start("Walker2d", "0.005"),
            "Unhealthy: height outside (0.8, 2) m or |pitch| ≥ 1 rad.",
            gymnasium_source("walker2d_v5"),
        ),
        rewards=RewardBounds(-25.0, 25.0),  # as Hopper
        camera=Camera(0.0, 0.65, 2.6, 90, -8),
        parts={
            "Torso": ("torso_geom",),
            "Thigh": ("thigh_geom", "thigh_left_geom"),
            "Leg": ("leg_geom", "leg_left_geom"),
            "Foot": ("foot_geom", "foot_left_geom"),
        },
        beams="pitch",
        wall_width=0.8,
        velocity_limit=10.0,
    ),
    Body(
        name="HalfCheetah",
        family="planar",
        asset="half_cheetah.xml",
        model_name="cheetah",
        prose=Prose(
            "A two-legged running body in the x–z plane. Its height is measured from 0.7 m.",
            "Δx/dt − 0.1·Σ a², with dt = 0.05 s.",
            "HalfCheetah's rest pose. Noise from U(−0.1, 0.1) is added to positions, from N(0, 0.1²) to "
            "velocities.",
            TIME_LIMIT_ONLY,
            gymnasium_source("half_cheetah_v5"),
        ),
        rewards=RewardBounds(-50.0, 50.0, terminates=False),  # the forward speed in m/s
        camera=Camera(0.0, 0.45, 2.8, 90, -8),
        parts={
            "Torso": ("torso",),
            "Thigh": ("fthigh", "bthigh"),
            "Leg": ("fshin", "bshin"),
            "Foot": ("ffoot", "bfoot"),
            "Head": ("head",),
        },
        beams="pitch",
        wall_width=0.8,
    ),
)
