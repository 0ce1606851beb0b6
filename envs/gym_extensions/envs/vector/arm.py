"""Pusher and Striker on whole arrays (Gymnasium's pusher_v5, and Striker rebuilt on it)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart
from gym_extensions.envs.effects.goals import (
    APART,
    PUSHER_GOAL,
    PUSHER_OBJECT,
    STRIKER_BALL,
    STRIKER_BALL_FIXED,
    STRIKER_GOAL,
)
from gym_extensions.envs.mujoco import pusher, striker
from gym_extensions.envs.vector.physics import Array, Lanes, Physics
from gym_extensions.envs.vector.rules import Flags
from gym_extensions.envs.vector.template import Prototype

ARM = 7
"""Joints of the arm, before those of the object."""
PUSH_NEAR, PUSH_CTRL = 0.5, 0.1
Place = tuple[Array, Array]


def distance(difference: Array) -> Array:
    """Length of each row, m; rounded as ``numpy.linalg.norm`` of one vector, which is a dot product too."""
    lengths: Array = np.sqrt(np.vecdot(difference, difference))
    return lengths


class Arm:
    """What pushing and striking share: the observation, and places read as the last evaluation left them."""

    pooled: ClassVar[bool] = False
    fields: ClassVar[tuple[str, ...]] = ("xpos",)

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        self._lanes = lanes
        self._qpos, self._qvel = physics.field("qpos"), physics.field("qvel")
        places, model = physics.field("xpos"), lanes[0].model
        self._tip, self._object, self._goal = (
            places[:, model.body(name).id] for name in ("tips_arm", "object", "goal")
        )

    def before(self) -> None:
        """The reward compares with nothing."""

    def started(self, lanes: Lanes) -> None:
        """Nothing is carried."""

    def observe(self) -> Array:
        """The arm's positions and velocities, then the places of tip, object and goal."""
        arm = self._qpos[:, :ARM], self._qvel[:, :ARM]
        return np.concatenate((*arm, self._tip, self._object, self._goal), axis=1)

    def carried(self) -> dict[str, Array]:
        """Nothing beside the physics."""
        return {}

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Nothing beside the physics."""


class Pushing(Arm):
    """Pusher: object to goal, tip to object, a cost on the action as given; never ends."""

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        super().__init__(physics, lanes)
        self._moving = [any(isinstance(own, MovingGoal) for own in lane.task.variations) for lane in lanes]

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> dict[str, Array]:
        """Goal where it moves, object away from it, arm velocities."""
        drawn = [self._draw(int(lane), own) for lane, own in zip(lanes, generators, strict=True)]
        return {name: np.array([row[name] for row in drawn]) for name in ("qpos", "qvel")}

    def _draw(self, lane: int, generator: np.random.Generator) -> dict[str, Array]:
        start = self._lanes[lane]
        goal = PUSHER_GOAL.draw(generator) if self._moving[lane] else np.zeros(2)
        place = PUSHER_OBJECT.draw(generator)
        while not np.linalg.norm(place - goal) > APART:
            place = PUSHER_OBJECT.draw(generator)
        speed = pusher.ARM_SPEED
        qvel = start.init_qvel + generator.uniform(-speed, speed, start.model.nv)
        qvel[-4:] = 0
        return {"qpos": np.concatenate((start.init_qpos[:-4], place, goal)), "qvel": qvel}

    def outcome(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """−distance of object and goal − .1·Σ action² − .5 × distance of tip and object."""
        near = -distance(self._object - self._tip) * PUSH_NEAR
        far = -distance(self._object - self._goal)
        cost = -np.square(actions).sum(axis=1) * PUSH_CTRL
        return far + cost + near, np.zeros(len(near), np.bool_)


class Striking(Arm):
    """Striker: smallest distance of ball and goal so far, tip to ball until struck; never ends."""

    def __init__(self, physics: Physics, lanes: Sequence[Prototype]) -> None:
        super().__init__(physics, lanes)
        self._moving = [any(isinstance(own, MovingStart) for own in lane.task.variations) for lane in lanes]
        self._height = mujoco.MjData(lanes[0].model).mocap_pos[0, 2]
        self._best = np.full(len(lanes), np.inf)
        self._struck = np.zeros(len(lanes), np.bool_)
        self._strike_place = np.zeros((len(lanes), 3))

    def draw(self, lanes: Lanes, generators: Sequence[np.random.Generator]) -> dict[str, Array]:
        """Ball where it moves, goal away from it and turned to it, arm velocities."""
        drawn = [self._draw(int(lane), own) for lane, own in zip(lanes, generators, strict=True)]
        return {name: np.array([row[name] for row in drawn]) for name in drawn[0]}

    def _draw(self, lane: int, generator: np.random.Generator) -> dict[str, Array]:
        start = self._lanes[lane]
        ball = STRIKER_BALL.draw(generator) if self._moving[lane] else np.array(STRIKER_BALL_FIXED)
        goal = STRIKER_GOAL.draw(generator)
        while not np.linalg.norm(ball - goal) >= APART:
            goal = STRIKER_GOAL.draw(generator)
        qvel = start.init_qvel.copy()
        qvel[:ARM] = generator.uniform(-striker.ARM_SPEED, striker.ARM_SPEED, ARM)
        return {
            "qpos": np.concatenate((start.init_qpos[:ARM], ball[::-1])),
            "qvel": qvel,
            "mocap_pos": np.array([[*goal, self._height]]),
            "mocap_quat": striker.facing(ball, goal)[None],
        }

    def started(self, lanes: Lanes) -> None:
        """The episode's record starts anew; the distance at reset counts."""
        self._struck[lanes], self._strike_place[lanes] = False, 0.0
        self._best[lanes] = self._ball_to_goal()[lanes]

    def _ball_to_goal(self) -> Array:
        return distance(self._object - self._goal)

    def outcome(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """−3 × best distance − .1·Σ action² − .5 × distance of ball and tip (where it struck, if it has)."""
        self._best = np.minimum(self._best, self._ball_to_goal())
        within = distance(self._tip - self._object) < striker.STRIKE
        self._struck |= within
        self._strike_place[within] = self._tip[within]
        near = distance(self._object - np.where(self._struck[:, None], self._strike_place, self._tip))
        cost = -striker.CTRL_WEIGHT * np.square(actions).sum(axis=1)
        reward = -striker.DISTANCE_WEIGHT * self._best + cost + -striker.NEAR_WEIGHT * near
        return reward, np.zeros(len(reward), np.bool_)

    def carried(self) -> dict[str, Array]:
        """Best distance, whether the ball was struck, and from where."""
        return {
            "best_distance": np.where(np.isfinite(self._best), self._best, 0.0),
            "struck": self._struck.astype(np.float64),
            "strike_place": self._strike_place.copy(),
        }

    def carry(self, lanes: Lanes, state: Mapping[str, Array]) -> None:
        """Takes the record of saved episodes."""
        self._best[lanes] = state["best_distance"]
        self._struck[lanes] = state["struck"] != 0
        self._strike_place[lanes] = state["strike_place"]
