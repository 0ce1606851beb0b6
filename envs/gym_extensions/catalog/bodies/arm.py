"""The two seven-joint arms."""

from __future__ import annotations

from gym_extensions.catalog.bodies.body import (
    TIME_LIMIT_ONLY,
    Body,
    Camera,
    Prose,
    Rectangle,
    RewardBounds,
    Segments,
    gymnasium_source,
)
from gym_extensions.catalog.bodies.success import Distance

ARM_CAMERA = Camera(0.4, -0.35, 2.6, 100, -62, after_reset=True)
"""From above, so that arm, object and goal do not hide each other."""
MAX_STEPS = 100
SEGMENTS = Segments(steps=5)
SUCCESS_DISTANCE = 0.05
"""In m: the ``distance_threshold`` of Gymnasium-Robotics' FetchPush, and the radius of object and ball."""

ARMS = (
    Body(
        name="Pusher",
        family="arm",
        asset="pusher_v5.xml",
        model_name="arm3d",
        prose=Prose(
            "A seven-joint arm with a fork that pushes an object to a goal on a table.",
            "−|object − goal| − 0.1·Σ a² − 0.5·|object − tip|.",
            "Arm stretched, joint velocities from U(−0.005, 0.005) rad/s. The goal is at (0.45, −0.05). The "
            "object's offsets from the goal are y ~ U(−0.3, 0) and x ~ U(−0.2, 0.2), drawn until their "
            "distance exceeds 0.17 m.",
            TIME_LIMIT_ONLY,
            gymnasium_source("pusher_v5"),
        ),
        rewards=RewardBounds(-30.0, 0.0, terminates=False),  # minus distances in m, minus squared actions
        camera=ARM_CAMERA,
        segments=SEGMENTS,
        max_steps=MAX_STEPS,
        has_gravity=False,
        goal_area=Rectangle((-0.2, -0.1), (0.0, 0.3)),  # slide offsets (y, x)
        success=Distance(
            ("object", "goal"),
            SUCCESS_DISTANCE,
            "At the last step, the centers of object and goal are at most 0.05 m apart on the table.",
        ),
    ),
    Body(
        name="Striker",
        family="arm",
        asset="pusher_v5.xml",
        model_name="arm3d",
        prose=Prose(
            "A seven-joint arm with a paddle that strikes a ball into a cup on a table.",
            "−3·d − 0.1·Σ a² − 0.5·n. d is the smallest distance between ball and goal so far in the "
            "episode, including the start. n is the distance between ball and tip until the tip first comes "
            "within 0.1 m of the ball, and afterwards the distance from the ball to the point where the tip "
            "was last within 0.1 m.",
            "Arm stretched, joint velocities from U(−0.1, 0.1) rad/s. The ball is at (0.5, −0.175), the goal "
            "at x ~ U(0.15, 0.7), y ~ U(0.1, 1), turned so that its open side faces the ball.",
            TIME_LIMIT_ONLY,
            "Gym's Striker-v0 (removed in 2022), rebuilt on Gymnasium's `pusher_v5.xml`.",
        ),
        rewards=RewardBounds(-200.0, 0.0, terminates=False),  # as Pusher; the ball may fly off the table
        camera=ARM_CAMERA,
        segments=SEGMENTS,
        max_steps=MAX_STEPS,
        has_gravity=False,
        goal_area=Rectangle((0.15, 0.1), (0.7, 1.0)),  # world (x, y)
        success=Distance(
            ("object", "goal"),
            SUCCESS_DISTANCE,
            "At the last step, the centers of ball and goal are at most 0.05 m apart on the table.",
        ),
    ),
)
