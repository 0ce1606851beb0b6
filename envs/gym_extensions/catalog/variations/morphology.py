"""Body parts that are wider and heavier, or thinner and lighter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.bodies import body_of_model
from gym_extensions.catalog.variations.base import BaseVariation, set_positive
from gym_extensions.errors import BenchError, did_you_mean

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies.body import Body, Feet


@dataclass(frozen=True)
class LimbScale(BaseVariation):
    """Multiplies the width and the mass of a body part by a factor (the paper: Big 1.25, Small 0.75).

    Width is the radius of a capsule or sphere. A capsule's length and end points stay. Inertia follows from
    the new shape and mass. Every other geom keeps its mass.
    """

    part: str
    factor: float

    def __post_init__(self) -> None:
        set_positive(self, "factor")

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body has parts that can be scaled."""
        return bool(body.parts)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Scales radius and mass of the part's geoms. Raises ``BenchError`` for an unknown part."""
        body = body_of_model(spec.modelname)
        geoms = [spec.geom(name) for name in self._geom_names(spec.modelname, body)]
        before = {geom.name: mass(geom) for geom in geoms}
        _raise_total(spec, (self.factor - 1) * sum(before.values()))
        for geom in geoms:
            geom.size[0] *= self.factor
            geom.mass = self.factor * before[geom.name]
        if body is not None and body.feet is not None and _overlap(spec, body.feet):
            first, second = body.feet.names
            spec.add_exclude(bodyname1=first, bodyname2=second)

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        geoms = [spec.geom(name) for name in body.parts[self.part]]
        total = sum(mass(geom) for geom in spec.geoms)
        scale = spec.compiler.settotalmass / total if spec.compiler.settotalmass > 0 else 1.0
        before = sum(mass(geom) for geom in geoms) * scale
        radii = ", ".join(
            f"{geom.name} {geom.size[0]:g} → {geom.size[0] * self.factor:.6g} m" for geom in geoms
        )
        return (
            f"{self.part}: radius and mass × {self.factor:g} "
            f"(radius: {radii}; mass {before:.4g} → {before * self.factor:.4g} kg)."
        )

    def _geom_names(self, model: str, body: Body | None) -> tuple[str, ...]:
        parts = body.parts if body is not None else {}
        if self.part not in parts:
            name = body.name if body is not None else model
            message = f"{name} has no part {self.part!r}."
            raise BenchError("unknown-part", message, hint=did_you_mean(str(self.part), parts))
        return parts[self.part]


def mass(geom: mujoco.MjsGeom) -> float:
    """The geom's mass before compilation, in kg.

    If it is not set, it is density × volume of a capsule or sphere.
    """
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


def _raise_total(spec: mujoco.MjSpec, increase: float) -> None:
    """Raises the total to which HalfCheetah's compiler scales all masses, so that no other mass moves."""
    total = float(spec.compiler.settotalmass)
    if total > 0:
        spec.compiler.settotalmass = total + increase * total / math.fsum(mass(geom) for geom in spec.geoms)


def _overlap(spec: mujoco.MjSpec, feet: Feet) -> bool:
    """Whether the feet touch in the rest pose and may collide, so that an episode would start with a kick."""
    radii = [float(spec.geom(name).size[0]) for name in feet.names]
    return not spec.excludes and sum(radii) > feet.distance
