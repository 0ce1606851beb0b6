"""The beams of the range sensor on arrays: where they lie, what they read of the wall, and their noise."""

import math
from collections.abc import Callable

import numpy as np

from gym_extensions.catalog.bodies import Frame
from gym_extensions.envs.interfaces import Array, Flags

BEAMS = 10
REACH = 10.0
"""Longest distance that a beam measures, m; a reading is distance / reach."""
ANGLES = tuple(math.radians(-45 + 10 * beam) for beam in range(BEAMS))
"""Beam angles about the forward axis, rad: beam 0 looks down, beam 9 up."""

_COS = np.array([math.cos(angle) for angle in ANGLES])
_SIN = np.array([math.sin(angle) for angle in ANGLES])

Lift = Array | float
Fan = Callable[[Array, Lift], tuple[Array, Array]]
"""(root qpos (…, nq), height of the torso at root z = 0 (…)) -> origins (…, 3), directions (…, 10, 3)."""


def planar_fan(qpos: Array, lift: Lift) -> tuple[Array, Array]:
    """Beams of a body on slides x, z and hinge y, which turn with its pitch."""
    origins, directions = np.zeros((*qpos.shape[:-1], 3)), np.zeros((*qpos.shape[:-1], BEAMS, 3))
    origins[..., 0], origins[..., 2] = qpos[..., 0], lift + qpos[..., 1]
    cos, sin = np.cos(qpos[..., 2])[..., None], np.sin(qpos[..., 2])[..., None]
    directions[..., 0], directions[..., 2] = _COS * cos + _SIN * sin, _SIN * cos - _COS * sin
    return origins, directions


def torso_fan(qpos: Array, lift: Lift) -> tuple[Array, Array]:
    """Beams in the x–z plane of a free torso, which turn with its quaternion (of any length except 0)."""
    w, x, y, z = (qpos[..., index] for index in (3, 4, 5, 6))
    square = w * w + x * x + y * y + z * z
    forward = np.stack([w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)
    up = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z], axis=-1)
    forward, up = forward / square[..., None], up / square[..., None]
    return _lifted(qpos, lift), _COS[:, None] * forward[..., None, :] + _SIN[:, None] * up[..., None, :]


def world_fan(qpos: Array, lift: Lift) -> tuple[Array, Array]:
    """Beams in the world's x–z plane about +x at any attitude of the torso, for bodies that start lying."""
    directions = np.stack([_COS, np.zeros(BEAMS), _SIN], axis=-1)
    return _lifted(qpos, lift), np.broadcast_to(directions, (*qpos.shape[:-1], BEAMS, 3))


def _lifted(qpos: Array, lift: Lift) -> Array:
    return np.stack([qpos[..., 0], qpos[..., 1], lift + qpos[..., 2]], axis=-1)


FANS: dict[Frame | None, Fan] = {"pitch": planar_fan, "torso": torso_fan, "world": world_fan}
"""The fan of every frame in which a body's beams can be fixed."""


def readings(origins: Array, directions: Array, center: Array, half_sizes: Array) -> Array:
    """Returns the distance to an axis-aligned box along each beam / 10 m, in [0, 1], (n, 10).

    A beam that misses, or starts inside the box, reads 0. Environments compile the function.

    Args:
        origins: (n, 3), m.
        directions: (n, 10, 3), of length 1.
        center: (n, 3) of the box, m.
        half_sizes: (3,) of the box, m.
    """
    found = np.zeros(directions.shape[:2])
    for row in range(len(origins)):
        for beam in range(BEAMS):
            enters, leaves = -np.inf, np.inf
            for axis in range(3):  # the beam is between two faces from ``near`` to ``far``
                along, offset = directions[row, beam, axis], center[row, axis] - origins[row, axis]
                near, far = (offset - half_sizes[axis]) / along, (offset + half_sizes[axis]) / along
                if along == 0:
                    between = abs(offset) <= half_sizes[axis]
                    near, far = (-np.inf, np.inf) if between else (np.inf, -np.inf)
                elif along < 0:
                    near, far = far, near
                enters, leaves = np.maximum(enters, near), np.minimum(leaves, far)
            if 0 <= enters <= leaves and enters <= REACH:
                found[row, beam] = enters / REACH
    return found


def beam_noise(seed: int, steps: int, dropout: float, noise: float) -> tuple[Flags, Array]:
    """The noise of an episode, with one row per step from 0 for the working beams and the noise on hits.

    Both arrays are (steps + 1, 10) and follow from the seed.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    shape = (steps + 1, BEAMS)
    return generator.random(shape) >= dropout, noise * generator.standard_normal(shape)


def disturb(readings: Array, working: Flags, shift: Array) -> Array:
    """Adds noise to beams that hit, clipped to [0, 1]. Beams that miss or drop out read 0."""
    return np.where((readings > 0) & working, np.clip(readings + shift, 0.0, 1.0), 0.0)
