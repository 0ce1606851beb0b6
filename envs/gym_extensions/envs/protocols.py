"""Array types, and what effects and rules may use of a simulation without knowing its class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
"""Indices of environments in a vector environment or a shard."""
Steps = NDArray[np.int64]
Generators = Sequence[np.random.Generator]
States = Mapping[str, Array]
"""Saved states by name; with a leading axis, one row per environment."""


class Simulation(Protocol):
    """One MuJoCo environment."""

    model: mujoco.MjModel
    data: mujoco.MjData

    @property
    def np_random(self) -> np.random.Generator:
        """The environment's generator."""

    @property
    def dt(self) -> float:
        """Seconds per environment step."""

    @property
    def elapsed(self) -> int:
        """Environment steps since reset."""

    @property
    def root_lift(self) -> float:
        """Height of the torso's frame when the root's vertical coordinate is 0, m."""

    def goal_position(self) -> Array:
        """The two coordinates of a moving goal, (2,), as a view into the state."""


class Template(Protocol):
    """One task's model and constants, shared by all its copies in a vector environment."""

    @property
    def task(self) -> Task:
        """The task."""

    @property
    def model(self) -> mujoco.MjModel:
        """The compiled model."""

    @property
    def init_qpos(self) -> Array:
        """Positions of the rest pose, (nq,)."""

    @property
    def init_qvel(self) -> Array:
        """Velocities of the rest pose, (nv,)."""

    @property
    def dt(self) -> float:
        """Seconds per environment step."""

    @property
    def root_lift(self) -> float:
        """Height of the torso's frame in m when the root's vertical coordinate is 0. The arms have 0."""


class Physics(Protocol):
    """Copies of one model layout, stepped together.

    Arrays have the environment as first axis and are live: every call refreshes them.
    """

    def field(self, name: str) -> Array:
        """A field of MjData of every environment, ``(num_envs, …)``, read-only by agreement."""

    def reset(self, indices: Indices, state: States) -> None:
        """Resets some environments to the model's defaults and writes the given rows of the state.

        Then runs mj_forward, if derived fields are read; it leaves the state as it is.
        """

    def step(self, ctrl: NDArray[Any], indices: Indices | None) -> None:
        """Runs one environment step with controls ``(num_envs, nu)`` in some environments, or in all."""

    def snapshot(self) -> dict[str, Array]:
        """Copies of the physics state of every environment, by the names of ``state_fields``."""

    def load(self, indices: Indices, state: States) -> None:
        """Writes saved rows of every state field into some environments, and recomputes derived fields."""

    def dump(self) -> dict[str, Array]:
        """Copies of everything that determines later steps and fields, for ``undump`` of a copy."""

    def undump(self, dumped: dict[str, Array]) -> None:
        """Writes what ``dump`` of the same simulations returned, bit for bit."""

    def close(self) -> None:
        """Frees threads and memory."""
