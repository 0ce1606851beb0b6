"""What every MuJoCo task adds to Gymnasium's class of its base body."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, ClassVar

import mujoco
import numpy as np
from gymnasium.envs.mujoco import MujocoEnv
from gymnasium.spaces import Box
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs import state
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.effects.registry import parts
from gym_extensions.envs.mujoco.compile import compile_model

Array = NDArray[np.float64]


class TaskEnv(MujocoEnv):
    """Mixed in before a Gymnasium body class: the model is the task's, actions are checked, state is carried.

    Pickling keeps the task and the rendering arguments: the copy is a fresh environment of the same task.
    """

    LAGGING: ClassVar[tuple[str, ...]] = ()
    """Fields of ``mjData`` that the next reward reads as the step before left them."""

    def __init__(self, task: Task, **rendering: Any) -> None:
        self.task = task
        self._parts = parts(task)
        super().__init__(**rendering)
        # The body class has set these to its own arguments.
        self._ezpickle_args: tuple[object, ...] = (task,)
        self._ezpickle_kwargs: dict[str, object] = rendering
        body = self.body_observation().size
        appended = sum(part.observed(self).size for part in self._parts)
        low, high = np.full(body + appended, -np.inf), np.full(body + appended, np.inf)
        low[body:], high[body:] = 0.0, 1.0
        self.observation_space = Box(low, high, dtype=np.float64)

    def _initialize_simulation(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        model = compile_model(self.task)
        size = model.vis.global_
        size.offwidth, size.offheight = max(size.offwidth, self.width), max(size.offheight, self.height)
        return model, mujoco.MjData(model)

    @property
    def elapsed(self) -> int:
        """Environment steps since reset, by the simulation's clock."""
        return round(float(self.data.time) / self.dt)

    @functools.cached_property
    def root_lift(self) -> float:
        """Height of the torso's frame when the root's vertical coordinate is 0, m."""
        torso = self.model.body("torso").id
        joint = self.model.body_jntadr[torso]
        free = self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
        return 0.0 if free else float(self.model.body_pos[torso, 2] - self.model.qpos0[joint + 1])

    def step(self, action: Any) -> tuple[Array, Any, bool, bool, dict[str, Any]]:
        """The base body's step, after the action's check; raises ``BenchError`` for a bad action."""
        checked = check_actions(action, (self.model.nu,), self.task.id)
        outcome: tuple[Array, Any, bool, bool, dict[str, Any]] = super().step(checked)
        return outcome

    def do_simulation(self, ctrl: Any, n_frames: int) -> None:
        """The base's physics step, with the parts acting before it and on the command."""
        for part in self._parts:
            part.before(self)
            ctrl = part.applied(self, ctrl)
        super().do_simulation(ctrl, n_frames)

    def start_body(self) -> None:
        """Draws and sets the body's own start."""
        super().reset_model()

    def reset_model(self) -> Array:
        """The first observation after the body's start and the parts' draws."""
        self.start_body()
        for part in self._parts:
            part.reset(self)
        if self._parts:
            # As if all had been placed before the first evaluation.
            self.data.qacc_warmstart[:] = 0
            mujoco.mj_forward(self.model, self.data)
        return self._get_obs()

    def body_observation(self) -> Array:
        """The base body's own observation."""
        observation: Array = super()._get_obs()  # type: ignore[misc]
        return observation

    def _get_obs(self) -> Array:
        appended = [part.observed(self) for part in self._parts]
        return np.concatenate([self.body_observation(), *appended]) if appended else self.body_observation()

    def goal_place(self) -> Array:
        """The two coordinates of a goal that moves, as a view into the state; bodies with a goal have one."""
        raise ValueError(f"{self.task.id} has no goal")

    def carried(self) -> state.State:
        """The task's own state by name."""
        return {}

    def carry(self, saved: Mapping[str, Array]) -> None:
        """Takes back what ``carried`` gave."""

    def save_state(self) -> state.State:
        """A copy of the state between two steps as float64 arrays by name.

        ``qpos``, ``qvel``, ``qacc_warmstart``, ``time`` always, ``mocap_pos``, ``mocap_quat`` where the model
        has mocap bodies, a task's own values under their names. Names beginning ``derived_`` hold what
        follows from the rest or from the reset seed, but for a lag of one evaluation.
        """
        saved = state.take(self.data, self.LAGGING) | self.carried()
        for part in self._parts:
            saved |= part.carried()
        return saved

    def restore_state(self, saved: Mapping[str, Array]) -> None:
        """Puts a saved state back: what follows is bit for bit what followed when it was saved.

        Derived values may be absent: then the first step's reward may differ, and the noise of an episode is
        that of the last reset.

        Raises:
            BenchError: a value is missing, unknown, of another shape or not finite.
        """
        checked = state.check(saved, self.save_state(), self.task.id)
        state.put(self.model, self.data, checked, self.LAGGING)
        self.carry(checked)
        for part in self._parts:
            part.carry(checked)
