"""Reward, start and end of each base body, in words; the numbers are those of their classes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Prose:
    """What a base body is and how an episode goes."""

    what: str
    reward: str
    start: str
    end: str
    source: str


RUNNING_START = "{body}'s rest pose; every position and velocity moved by noise from U(−{noise}, {noise})."
HUMANOID_COSTS = "0.1·Σ ctrl² − min(5e-7·Σ cfrc_ext², 10)"
SOURCE = "Gymnasium 1.4, `gymnasium/envs/mujoco/{file}.py`, default arguments."

PROSE = {
    "Hopper": Prose(
        "A one-legged body in the x–z plane that hops forward.",
        "Δx/dt + 1 while healthy − 0.001·Σ a², with dt = 0.008 s.",
        RUNNING_START.format(body="Hopper", noise="0.005"),
        "Unhealthy: height ≤ 0.7 m, or |pitch| ≥ 0.2 rad, or another coordinate or velocity beyond ±100.",
        SOURCE.format(file="hopper_v5"),
    ),
    "Walker2d": Prose(
        "A two-legged body in the x–z plane that walks forward.",
        "Δx/dt + 1 while healthy − 0.001·Σ a², with dt = 0.008 s.",
        RUNNING_START.format(body="Walker2d", noise="0.005"),
        "Unhealthy: height outside (0.8, 2) m or |pitch| ≥ 1 rad.",
        SOURCE.format(file="walker2d_v5"),
    ),
    "HalfCheetah": Prose(
        "A two-legged running body in the x–z plane. Its height is counted from 0.7 m.",
        "Δx/dt − 0.1·Σ a², with dt = 0.05 s.",
        "HalfCheetah's rest pose; positions moved by U(−0.1, 0.1), velocities by N(0, 0.1²).",
        "Never; only the time limit.",
        SOURCE.format(file="half_cheetah_v5"),
    ),
    "Humanoid": Prose(
        "A three-dimensional two-legged body with arms that walks forward.",
        f"1.25·Δx/dt + 5 while healthy − {HUMANOID_COSTS}; Δx is that of the centre of mass, dt = 0.015 s.",
        RUNNING_START.format(body="Humanoid", noise="0.01"),
        "Unhealthy: height of the torso outside (1, 2) m.",
        SOURCE.format(file="humanoid_v5"),
    ),
    "HumanoidStandup": Prose(
        "Humanoid lying on its back that stands up.",
        f"z/0.003 + 1 − {HUMANOID_COSTS}; z is the height of the torso.",
        RUNNING_START.format(body="HumanoidStandup", noise="0.01"),
        "Never; only the time limit.",
        SOURCE.format(file="humanoidstandup_v5"),
    ),
    "HumanoidStandupAndRun": Prose(
        "Humanoid lying on its back that stands up and runs.",
        f"1.25·Δx/dt + z/0.003 + (5 if 1 < z < 2, else 1) − {HUMANOID_COSTS}; Δx is that of the centre of "
        "mass, z the height of the torso, dt = 0.015 s.",
        RUNNING_START.format(body="HumanoidStandup", noise="0.01"),
        "Never; only the time limit.",
        "The paper's task, on Gymnasium's `humanoidstandup.xml` with Humanoid-v5's observation.",
    ),
    "Pusher": Prose(
        "A seven-joint arm with a fork that pushes an object to a goal on a table.",
        "−|object − goal| − 0.1·Σ a² − 0.5·|object − tip|.",
        "Arm stretched, joint velocities from U(−0.005, 0.005) rad/s. The goal lies at (0.45, −0.05); the "
        "object at offsets y ~ U(−0.3, 0), x ~ U(−0.2, 0.2) from there, drawn until farther than 0.17 m off.",
        "Never; only the time limit.",
        SOURCE.format(file="pusher_v5"),
    ),
    "Striker": Prose(
        "A seven-joint arm with a paddle that strikes a ball into a cup on a table.",
        "−3·d − 0.1·Σ a² − 0.5·n. d is the smallest distance of ball and goal in the episode so far, reset "
        "included; n the distance of ball and tip until the tip first comes within 0.1 m of the ball, from "
        "then on the distance from the ball to where the tip was when last within it.",
        "Arm stretched, joint velocities from U(−0.1, 0.1) rad/s. The ball lies at (0.5, −0.175), the goal "
        "at x ~ U(0.15, 0.7), y ~ U(0.1, 1), turned so that its open side faces the ball.",
        "Never; only the time limit.",
        "Gym's Striker-v0 (removed in 2022), rebuilt on Gymnasium's `pusher_v5.xml`.",
    ),
    "Navigation": Prose(
        "A point that finds its way over a map of 640 × 480 units to a goal.",
        "−1 every step, a further −5 on a collision, a further +10 on reaching the goal.",
        'Uniform over free space at least 100 units from the goal; `options={"start": (x, y)}` fixes it.',
        "Reaching the goal: within 20 units of its centre after the step.",
        "The paper, section on 2-D navigation.",
    ),
}
"""One entry a base body."""

HISTORY = {0: "first published version"}
"""What changed with each version number."""
