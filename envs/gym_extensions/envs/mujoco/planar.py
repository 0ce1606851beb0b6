"""Gymnasium's v5 classes of the three planar running bodies, with default arguments."""

from __future__ import annotations

from gymnasium.envs.mujoco.half_cheetah_v5 import HalfCheetahEnv
from gymnasium.envs.mujoco.hopper_v5 import HopperEnv
from gymnasium.envs.mujoco.walker2d_v5 import Walker2dEnv

from gym_extensions.envs.mujoco.task_env import TaskEnv


class Hopper(TaskEnv, HopperEnv):
    """Gymnasium's Hopper-v5 with the task's model."""


class Walker2d(TaskEnv, Walker2dEnv):
    """Gymnasium's Walker2d-v5 with the task's model."""


class HalfCheetah(TaskEnv, HalfCheetahEnv):
    """Gymnasium's HalfCheetah-v5 with the task's model."""
