"""A task's compiled MuJoCo model: Gymnasium's installed asset as an MjSpec, edited by its variations."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import gymnasium
import mujoco

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.catalog.variations.obstacles import Wall
from gym_extensions.envs.mujoco import striker_model

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
ASSET = {
    "Hopper": "hopper.xml",
    "Walker2d": "walker2d_v5.xml",
    "HalfCheetah": "half_cheetah.xml",
    "Humanoid": "humanoid.xml",
    "HumanoidStandup": "humanoidstandup.xml",
    "HumanoidStandupAndRun": "humanoidstandup.xml",
    "Pusher": "pusher_v5.xml",
    "Striker": "pusher_v5.xml",
}
"""The file that each base body is made from, as Gymnasium 1.4's v5 classes name it."""

REBUILT: dict[str, Callable[[mujoco.MjSpec], None]] = {"Striker": striker_model.rebuild}
"""Base bodies that Gymnasium has no file for: the edits that make them from another's."""


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


def base_spec(base: str) -> mujoco.MjSpec:
    """The specification of a base body without variations."""
    with _quiet():
        spec = mujoco.MjSpec.from_file(str(asset(base)))
    REBUILT.get(base, lambda _: None)(spec)
    return spec


def compile_model(task: Task) -> mujoco.MjModel:
    """The task's model, compiled directly from the edited specification.

    Writing XML out would round numbers, so nothing is written: an unvaried task's model equals Gymnasium's in
    every array. Variations are applied in an order of their own, so that the order given does not matter.
    """
    spec = base_spec(task.base)
    with _quiet():
        for variation in sorted(task.variations, key=_order):
            variation.apply(spec)
        return spec.compile()


def _order(variation: Variation) -> tuple[bool, str]:
    """The wall last: it keeps the extent of the model that it is added to."""
    return isinstance(variation, Wall), repr(variation)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Silences one warning: ``settotalmass`` is deprecated, and still what defines HalfCheetah's masses."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*settotalmass.*")
        yield
