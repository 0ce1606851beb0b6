"""Kinematics of a skeleton: where its shapes are for joint coordinates. ``static/watch.js`` repeats it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.descriptions import FREE, SLIDE, Role, Skeleton

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Placed:
    """A shape in every frame: its ends (frames, 2) in m, x to the right and y up, and its radius.

    For a wall, the ends are the lower left and the upper right corner.
    """

    role: Role
    radius: float
    start: Array
    end: Array


def placed(skeleton: Skeleton, coordinates: Array) -> list[Placed]:
    """The shapes of a skeleton for coordinates (frames, n), in the order of its links."""
    frames = len(coordinates)
    view = _view(*skeleton.view)
    origins, turns, shapes = list[Array](), list[Array](), list[Placed]()
    for link in skeleton.links:
        is_rooted = link.parent < 0
        parent_turn = np.broadcast_to(np.eye(3), (frames, 3, 3)) if is_rooted else turns[link.parent]
        parent_origin = np.zeros((frames, 3)) if is_rooted else origins[link.parent]
        origin = parent_origin + parent_turn @ np.array(link.position)
        turn = parent_turn @ _rotation(np.array(link.rotation))
        for joint in link.joints:
            axis, anchor = np.array(joint.axis), np.array(joint.anchor)
            if joint.kind == FREE:
                pose = coordinates[:, joint.coordinate : joint.coordinate + 7]
                origin, turn = pose[:, :3], _rotation(pose[:, 3:])
                continue
            moved = coordinates[:, joint.coordinate] - joint.rest
            if joint.kind == SLIDE:
                origin = origin + (turn @ axis) * moved[:, None]
                continue
            pivot = origin + turn @ anchor
            half = moved[:, None] / 2
            turn = turn @ _rotation(np.hstack([np.cos(half), np.sin(half) * axis]))
            origin = pivot - turn @ anchor
        origins.append(origin)
        turns.append(turn)
        for shape in link.shapes:
            start, end = np.array(shape.start), np.array(shape.end)
            if shape.role == "wall":
                start, end = start - end, start + end
            fixed = np.eye(3) if shape.role == "world-beam" else turn
            ends = [(origin + fixed @ point) @ view.T for point in (start, end)]
            shapes.append(Placed(shape.role, shape.radius, *ends))
    return shapes


def _view(azimuth: float, elevation: float) -> Array:
    """The directions to the right and up of a camera, rows of (2, 3)."""
    around, above = math.radians(azimuth), math.radians(elevation)
    right = np.array([math.sin(around), -math.cos(around), 0.0])
    ahead = np.array(
        [math.cos(above) * math.cos(around), math.cos(above) * math.sin(around), math.sin(above)]
    )
    return np.stack([right, np.cross(right, ahead)])


def _rotation(quaternion: Array) -> Array:
    """Rotation matrices (…, 3, 3) of quaternions (…, 4) of any length except 0."""
    w, x, y, z = np.moveaxis(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
