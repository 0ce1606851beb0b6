"""Lists the base bodies, with one row per body that holds all differences between them."""

from __future__ import annotations

from gym_extensions.catalog.bodies.arm import ARMS
from gym_extensions.catalog.bodies.body import UNBOUNDED, Body, RewardBounds, Segments
from gym_extensions.catalog.bodies.humanoid import HUMANOIDS
from gym_extensions.catalog.bodies.navigation import NAVIGATION
from gym_extensions.catalog.bodies.planar import PLANAR
from gym_extensions.errors import BenchError, did_you_mean

__all__ = ["BODIES", "UNBOUNDED", "Body", "RewardBounds", "Segments", "body", "body_of_model"]

BODIES: dict[str, Body] = {row.name: row for row in (*PLANAR, *HUMANOIDS, *ARMS, *NAVIGATION)}
"""Every base body by its name."""


def body(name: str, where: str = "") -> Body:
    """Returns the base body with that name.

    Raises:
        BenchError: no base body has that name; the hint names the closest.
    """
    if name not in BODIES:
        hint = did_you_mean(name, BODIES)
        raise BenchError("unknown-base", f"There is no base body {name!r}.", where, hint)
    return BODIES[name]


def body_of_model(model_name: str) -> Body | None:
    """Returns the first base body whose MuJoCo model has that name, or None.

    Bodies that share a model also share its parts.
    """
    return next((row for row in BODIES.values() if row.model_name == model_name), None)
