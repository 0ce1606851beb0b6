"""What every MuJoCo task adds to Gymnasium's class of its base body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import mujoco
import numpy as np
from gymnasium.envs.mujoco import MujocoEnv
from numpy.typing import NDArray

from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import state
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.models import compile_model


class TaskEnv(MujocoEnv):
    """Mixed in before a Gymnasium body class: the model is the task's, actions are checked, state is carried.

    Pickling keeps the task and the rendering arguments: the copy is a fresh environment of the same task.
    """

    LAGGING: ClassVar[tuple[str, ...]] = ()
    """Fields of ``mjData`` that the next reward reads as the step before left them."""

    def __init__(self, task: Task, **rendering: Any) -> None:
        self.task = task
        super().__init__(**rendering)
        # The body class has set these to its own arguments.
        self._ezpickle_args: tuple[object, ...] = (task,)
        self._ezpickle_kwargs: dict[str, object] = rendering

    def _initialize_simulation(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        model = compile_model(self.task)
        size = model.vis.global_
        size.offwidth, size.offheight = max(size.offwidth, self.width), max(size.offheight, self.height)
        return model, mujoco.MjData(model)

    def step(self, action: Any) -> tuple[NDArray[np.float64], Any, bool, bool, dict[str, Any]]:
        """The base body's step, after the action's check; raises ``BenchError`` for a bad action."""
        checked = check_actions(action, (self.model.nu,), self.task.id)
        outcome: tuple[NDArray[np.float64], Any, bool, bool, dict[str, Any]] = super().step(checked)
        return outcome

    def save_state(self) -> state.State:
        """A copy of the state between two steps as float64 arrays by name.

        ``qpos``, ``qvel``, ``qacc_warmstart``, ``time`` always, ``mocap_pos``, ``mocap_quat`` where the model
        has mocap bodies, a task's own values under their names. Names beginning ``derived_`` hold what
        follows from the rest or from the reset seed, but for a lag of one evaluation.
        """
        return state.take(self.data, self.LAGGING)

    def restore_state(self, saved: Mapping[str, NDArray[np.float64]]) -> None:
        """Puts a saved state back: what follows is bit for bit what followed when it was saved.

        Derived values may be absent; then the first step's reward may differ and nothing after it.

        Raises:
            BenchError: a value is missing, unknown, of another shape or not finite.
        """
        checked = state.check(saved, self.save_state(), self.task.id)
        state.put(self.model, self.data, checked, self.LAGGING)
