"""Compiles a task's MuJoCo model from Gymnasium's asset, edited as an MjSpec by the task's variations."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import gymnasium
import mujoco

from gym_extensions.catalog.bodies import Body
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.catalog.variations.obstacles import Wall
from gym_extensions.envs.mujoco import striker_model

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
REBUILT: dict[str, Callable[[mujoco.MjSpec], None]] = {"Striker": striker_model.rebuild}
"""Base bodies without a model file of their own, and the function that makes them from another body's."""


def asset(body: Body) -> Path:
    """The file of a base body's model among Gymnasium's installed assets."""
    return ASSETS / body.asset


def base_spec(body: Body) -> mujoco.MjSpec:
    """The specification of a base body without variations."""
    with _quiet():
        spec = mujoco.MjSpec.from_file(str(asset(body)))
    if body.name in REBUILT:
        REBUILT[body.name](spec)
    return spec


def compile_model(task: Task) -> mujoco.MjModel:
    """Compiles the task's model directly from the edited specification.

    Writing XML would round numbers. Without it, the model of a task without variations equals Gymnasium's in
    every array. Variations are applied in a fixed order, so their order in the task does not matter.
    """
    spec = base_spec(task.body)
    with _quiet():
        for variation in sorted(task.variations, key=_order):
            variation.apply(spec)
        return spec.compile()


def _order(variation: Variation) -> tuple[bool, str]:
    """Sorts the wall last, because it keeps the extent of the model to which it is added."""
    return isinstance(variation, Wall), repr(variation)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Silences the deprecation warning of ``settotalmass``, which defines HalfCheetah's masses."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*settotalmass.*")
        yield
