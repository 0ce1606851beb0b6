"""A task's compiled MuJoCo model: Gymnasium's installed asset as an MjSpec, edited by its variations."""

from __future__ import annotations

import warnings
from pathlib import Path

import gymnasium
import mujoco

from gym_extensions.catalog.tasks import Task

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
ASSET = {
    "Hopper": "hopper.xml",
    "Walker2d": "walker2d_v5.xml",
    "HalfCheetah": "half_cheetah.xml",
    "Humanoid": "humanoid.xml",
}
"""The file that each base body is made from, as Gymnasium 1.4's v5 classes name it."""


def asset(base: str) -> Path:
    """The file of a base body's model among Gymnasium's installed assets."""
    return ASSETS / ASSET[base]


def base_bytes(task: Task) -> bytes:
    """The bytes of the file that the task's base is made from; a fingerprint pins their digest."""
    if task.base == "Navigation":
        from gym_extensions.envs.navigation.build import base_bytes as navigation

        content: bytes = navigation(task)
        return content
    return asset(task.base).read_bytes()


def compile_model(task: Task) -> mujoco.MjModel:
    """The task's model, compiled directly from the edited specification.

    Writing XML out would round numbers, so nothing is written: an unvaried task's model equals Gymnasium's in
    every array. HalfCheetah's ``settotalmass`` is deprecated in MuJoCo 4 and still what defines its masses.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*settotalmass.*")
        spec = mujoco.MjSpec.from_file(str(asset(task.base)))
        for variation in task.variations:
            variation.apply(spec)
        return spec.compile()
