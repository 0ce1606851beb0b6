"""The mixin that turns Gymnasium's class of a body into the environment of a task."""

from __future__ import annotations

import copy
import functools
from collections.abc import Mapping
from typing import Any, ClassVar

import mujoco
import numpy as np
from gymnasium.envs.mujoco import MujocoEnv
from gymnasium.spaces import Box

from gym_extensions.catalog.bodies.success import IS_SUCCESS
from gym_extensions.catalog.task import Task
from gym_extensions.envs import state
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.effects.registry import effects_of
from gym_extensions.envs.lifecycle import IndependentCopies, require_reset
from gym_extensions.envs.mujoco.compile import compile_model
from gym_extensions.envs.protocols import Array
from gym_extensions.envs.success import success_test

REBUILT = ("model", "data", "mujoco_renderer")
"""Attributes that a copy makes again."""


class TaskEnv(IndependentCopies, MujocoEnv):
    """A mixin before a Gymnasium body class.

    It supplies the task's model, checks actions, saves and restores state. Copies and pickles continue
    exactly where the original is, with their own generator.
    """

    observation_space: Box
    action_space: Box

    ONE_STEP_BEHIND: ClassVar[tuple[str, ...]] = ()
    """Fields of ``mjData`` that the next reward reads as the previous step left them."""

    def __init__(self, task: Task, **rendering: Any) -> None:
        self.task = task
        self._is_set = False
        self._effects = effects_of(task)
        super().__init__(**rendering)
        # The body class has set these to its own arguments.
        self._ezpickle_args: tuple[object, ...] = (task,)
        self._ezpickle_kwargs: dict[str, object] = rendering
        self._success = success_test(task.body.success, self.model)
        body = self.body_observation().size
        appended = sum(effect.observation(self).size for effect in self._effects)
        low, high = np.full(body + appended, -np.inf), np.full(body + appended, np.inf)
        low[body:], high[body:] = 0.0, 1.0
        self.observation_space = Box(low, high, dtype=np.float64)

    def _initialize_simulation(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        model = compile_model(self.task)
        size = model.vis.global_
        size.offwidth, size.offheight = max(size.offwidth, self.width), max(size.offheight, self.height)
        return model, mujoco.MjData(model)

    def __getstate__(self) -> dict[str, Any]:
        """Returns a copy of the whole simulation and the other attributes."""
        others = {name: value for name, value in self.__dict__.items() if name not in REBUILT}
        return {"attributes": others, "data": copy.copy(self.data)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Makes the environment again and continues where the copied one was."""
        attributes = state["attributes"]
        new = type(self)(*attributes["_ezpickle_args"], **attributes["_ezpickle_kwargs"])
        self.__dict__.update(new.__dict__ | attributes)
        mujoco.mj_copyData(self.data, self.model, state["data"])

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
        """The base body's step, after a check of the action.

        The info has ``is_success``, a bool, if the task defines success.

        Raises:
            BenchError: the action's shape differs, or a value is not a finite number.
            ResetNeededError: the environment was never reset.
        """
        require_reset(self._is_set, self.task.id)
        checked = check_actions(action, (self.model.nu,), self.task.id)
        transition: tuple[Array, Any, bool, bool, dict[str, Any]] = super().step(checked)
        if self._success is not None:
            transition[4][IS_SUCCESS] = bool(self._success(getattr(self.data, self._success.field)))
        return transition

    def do_simulation(self, ctrl: Any, n_frames: int) -> None:
        """The base body's physics step, after the effects have acted on the state and the command."""
        for effect in self._effects:
            effect.pre_step(self)
            ctrl = effect.control(self, ctrl)
        super().do_simulation(ctrl, n_frames)

    def set_state(self, qpos: Array, qvel: Array) -> None:
        """Sets positions (nq,) and velocities (nv,) and recomputes derived fields."""
        super().set_state(qpos, qvel)  # type: ignore[no-untyped-call]
        self._is_set = True

    def start_body(self) -> None:
        """Draws and sets the body's own start."""
        super().reset_model()

    def reset_model(self) -> Array:
        """Returns the first observation, after the draws of the body and of the effects."""
        self.start_body()
        for effect in self._effects:
            effect.on_reset(self)
        if self._effects:
            # As if everything had been placed before the first evaluation.
            self.data.qacc_warmstart[:] = 0
            mujoco.mj_forward(self.model, self.data)
        return self._get_obs()

    def body_observation(self) -> Array:
        """The base body's own observation."""
        observation: Array = super()._get_obs()  # type: ignore[misc]
        return observation

    def _get_obs(self) -> Array:
        appended = [effect.observation(self) for effect in self._effects]
        return np.concatenate([self.body_observation(), *appended]) if appended else self.body_observation()

    def goal_position(self) -> Array:
        """The two coordinates of a moving goal, as a view into the state. Raises without a goal."""
        raise ValueError(f"{self.task.id} has no goal")

    def get_task_state(self) -> state.State:
        """Returns the body's own state by name, beside the physics."""
        return {}

    def set_task_state(self, saved: Mapping[str, Array]) -> None:
        """Restores what ``get_task_state`` returned."""

    def save_state(self) -> state.State:
        """Returns a copy of the state between two steps as float64 arrays by name.

        It has ``qpos``, ``qvel``, ``qacc_warmstart`` and ``time``, ``mocap_pos`` and ``mocap_quat`` if the
        model has mocap bodies, and the task's own values. Values whose names begin with ``derived_`` follow
        from the others or from the reset seed, up to a lag of one evaluation.

        Raises:
            ResetNeededError: the environment was never reset.
        """
        require_reset(self._is_set, self.task.id)
        return self._take_state()

    def _take_state(self) -> state.State:
        saved = state.take(self.data, self.ONE_STEP_BEHIND) | self.get_task_state()
        for effect in self._effects:
            saved |= effect.get_state()
        return saved

    def restore_state(self, saved: Mapping[str, Array]) -> None:
        """Restores a saved state.

        The continuation is bit for bit the same.

        Derived values may be absent. Then the first step's reward may differ, and the noise is that of the
        last reset.

        Raises:
            BenchError: a value is missing, unknown, not finite, or has another shape.
        """
        checked = state.check(saved, self._take_state(), self.task.id)
        state.put(self.model, self.data, checked, self.ONE_STEP_BEHIND)
        self.set_task_state(checked)
        for effect in self._effects:
            effect.set_state(checked)
        self._is_set = True
