"""What the modules of environments share: array types, templates, physics, and what is refused."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from gymnasium import error
from numpy.typing import NDArray

from gym_extensions.catalog.tasks import Task
from gym_extensions.errors import BenchError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
"""Indices of environments in a vector environment or a shard."""
Steps = NDArray[np.int64]
Generators = Sequence[np.random.Generator]
Starts = Mapping[str, Array]
"""States in which environments start, by the names of fields of ``mjData``, one row per environment."""


@dataclass(frozen=True, eq=False)
class Template:
    """What all copies of one MuJoCo task share: the compiled model and the rest pose."""

    task: Task
    model: mujoco.MjModel
    frame_skip: int
    init_qpos: Array
    init_qvel: Array

    @property
    def dt(self) -> float:
        """Seconds per environment step, computed as Gymnasium computes it."""
        return float(self.model.opt.timestep * self.frame_skip)

    @property
    def root_lift(self) -> float:
        """Height of the torso's frame when the root's vertical coordinate is 0, m."""
        torso = self.model.body("torso").id
        joint = self.model.body_jntadr[torso]
        if self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            return 0.0
        return float(self.model.body_pos[torso, 2] - self.model.qpos0[joint + 1])


class Physics:
    """Simulations of one model layout."""

    lost_threads = False
    _fields: dict[str, Array]

    def reset(self, indices: Indices, starts: Starts) -> None:
        """Starts some environments in the given rows of states."""

    def step(self, ctrl: NDArray[Any], indices: Indices | None) -> None:
        """Runs one environment step in some environments, or in all."""

    def states(self) -> dict[str, Array]:
        """Returns copies of the states by name, ``(num_envs, …)``."""
        raise NotImplementedError

    def close(self) -> None:
        """Ends the threads."""

    def require_threads(self) -> None:
        """Raises ``BenchError`` in a forked process, where a step would wait for lost threads for ever."""
        if self.lost_threads:
            hint = "Make the environments in the process that steps them, or with num_threads=1."
            raise BenchError("forked", "The threads stayed in the parent process.", "make_vec", hint)

    def field(self, name: str) -> Array:
        """Returns a live field, ``(num_envs, …)``."""
        return self._fields[name]


def check_actions(actions: Any, shape: tuple[int, ...], where: str) -> NDArray[Any]:
    """Returns the actions as an array, with dtype and values unchanged; values out of range pass.

    Raises ``BenchError`` if the shape is not ``(act,)``, or ``(num_envs, act)`` in a vector environment, or a
    value is not a finite number. It names ``where``.
    """
    hint = f"Give numbers of the shape {shape}."
    try:
        array = np.asarray(actions)
    except ValueError as error:
        raise BenchError("bad-action", "The parts of the action differ in shape.", where, hint) from error
    if array.shape != shape:
        raise BenchError("bad-action", f"The action has shape {array.shape}.", where, hint)
    if array.dtype.kind not in "fiu":
        message = f"The action has dtype {array.dtype}."
        raise BenchError("bad-action", message, where, "Give floating-point numbers.")
    if not np.isfinite(array).all():
        index = np.argwhere(~np.isfinite(array))[0].tolist()
        label, value = ", ".join(map(str, index)), array[tuple(index)]
        raise BenchError("bad-action", f"action[{label}] is {value}.", where, "Give finite numbers.")
    return array


class ResetNeededError(BenchError, error.ResetNeeded):
    """An environment has no state yet. It is also Gymnasium's error of that name."""


class ClosedError(BenchError, error.ClosedEnvironmentError):
    """A vector environment is used after ``close``. It is also Gymnasium's error for that."""


def require_reset(is_set: bool, where: str) -> None:
    """Raises ``ResetNeededError`` unless the environment has a state."""
    if not is_set:
        message = "The environment has no state before its first reset."
        raise ResetNeededError("reset-needed", message, where, "Call reset() first.")


def require_open(closed: bool, where: str) -> None:
    """Raises ``ClosedError`` if the environment is closed."""
    if closed:
        raise ClosedError("closed", "The environment is closed.", where, "Make a new one.")
