"""Body parts that are wider and heavier, or thinner and lighter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import positive
from gym_extensions.errors import BenchError, did_you_mean

if TYPE_CHECKING:
    import mujoco

_HUMANOID = {
    "Torso": ("torso1", "uwaist", "lwaist"),
    "Thigh": ("right_thigh1", "left_thigh1", "butt"),
    "Leg": ("right_shin1", "left_shin1"),
    "Foot": ("right_foot", "left_foot"),
    "Head": ("head",),
    "Arm": ("right_uarm1", "right_larm", "left_uarm1", "left_larm"),
    "Hand": ("right_hand", "left_hand"),
}
PARTS: dict[str, dict[str, tuple[str, ...]]] = {
    "hopper": {
        "Torso": ("torso_geom",),
        "Thigh": ("thigh_geom",),
        "Leg": ("leg_geom",),
        "Foot": ("foot_geom",),
    },
    "walker2d": {
        "Torso": ("torso_geom",),
        "Thigh": ("thigh_geom", "thigh_left_geom"),
        "Leg": ("leg_geom", "leg_left_geom"),
        "Foot": ("foot_geom", "foot_left_geom"),
    },
    "cheetah": {
        "Torso": ("torso",),
        "Thigh": ("fthigh", "bthigh"),
        "Leg": ("fshin", "bshin"),
        "Foot": ("ffoot", "bfoot"),
        "Head": ("head",),
    },
    "humanoid": _HUMANOID,
    "humanoidstandup": _HUMANOID,
}
"""The geoms of each part, by the name that Gymnasium's model file gives the model."""

BODIES = {
    "hopper": "Hopper",
    "walker2d": "Walker2d",
    "cheetah": "HalfCheetah",
    "humanoid": "Humanoid",
    "humanoidstandup": "HumanoidStandup",
    "arm3d": "The arm",
}
"""What the base bodies are called here, by the name in Gymnasium's model file."""

HUMANOID_FEET = ("right_foot", "left_foot")
HUMANOID_FEET_APART = 0.18
"""Distance of Humanoid's foot centres in the rest pose, m."""


@dataclass(frozen=True)
class LimbScale:
    """The width and the mass of a part times a factor (the paper's Big is 1.25, Small 0.75).

    Width is the radius of a capsule or sphere; a capsule's length and end points stay. Inertia follows from
    the new shape at the new mass. Every other geom keeps its mass.
    """

    part: str
    factor: float

    def __post_init__(self) -> None:
        positive(f"LimbScale's factor for {self.part!r}", self.factor)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Scales radius and mass of the part's geoms; raises ``BenchError`` if the body has no such part."""
        parts = PARTS.get(spec.modelname, {})
        if self.part not in parts:
            body = BODIES.get(spec.modelname, spec.modelname)
            message = f"{body} has no part {self.part!r} to scale."
            raise BenchError("unknown-part", message, hint=did_you_mean(str(self.part), parts))
        geoms = [spec.geom(name) for name in parts[self.part]]
        before = {geom.name: mass(geom) for geom in geoms}
        _raise_total(spec, (self.factor - 1) * sum(before.values()))
        for geom in geoms:
            geom.size[0] *= self.factor
            geom.mass = self.factor * before[geom.name]
        if _feet_overlap(spec):
            spec.add_exclude(bodyname1=HUMANOID_FEET[0], bodyname2=HUMANOID_FEET[1])


def mass(geom: mujoco.MjsGeom) -> float:
    """The geom's mass before compilation, kg: as set, else density × volume of a capsule or sphere."""
    if not math.isnan(geom.mass):
        return float(geom.mass)
    radius, half_length = float(geom.size[0]), float(geom.size[1])
    if not math.isnan(geom.fromto[0]):
        half_length = math.dist(geom.fromto[:3], geom.fromto[3:]) / 2
    if geom.type.name == "mjGEOM_SPHERE":
        half_length = 0.0
    elif geom.type.name != "mjGEOM_CAPSULE":
        return 0.0  # the floor; the base bodies have no other shapes
    return float(geom.density) * math.pi * radius**2 * (2 * half_length + 4 / 3 * radius)


def _raise_total(spec: mujoco.MjSpec, more: float) -> None:
    """Raises the total to which HalfCheetah's compiler scales all masses: no other geom's mass moves."""
    total = float(spec.compiler.settotalmass)
    if total > 0:
        spec.compiler.settotalmass = total + more * total / math.fsum(mass(geom) for geom in spec.geoms)


def _feet_overlap(spec: mujoco.MjSpec) -> bool:
    """Whether Humanoid's feet touch in the rest pose: an episode would start with a kick."""
    feet = [spec.geom(name) for name in HUMANOID_FEET]
    humanoid = spec.modelname.startswith("humanoid")
    return humanoid and not spec.excludes and sum(foot.size[0] for foot in feet) > HUMANOID_FEET_APART
