"""The single navigation environment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.success import IS_SUCCESS
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.maps import Course
from gym_extensions.envs import state
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.lifecycle import IndependentCopies, require_reset
from gym_extensions.envs.navigation.grid import Arena, arena
from gym_extensions.envs.navigation.observations import action_space, observation_space
from gym_extensions.envs.navigation.rendering import background, with_agent
from gym_extensions.envs.navigation.simulation import EXPECTED_STATE, World, whole_steps
from gym_extensions.errors import BenchError

RENDER_PIXEL = 1.0
"""Side of a pixel of a rendered frame, in units."""
WINDOW_HINT = 'For a window: gymnasium.wrappers.HumanRendering(make(..., render_mode="rgb_array")).'


def course(task: Task) -> Course:
    """Returns the course of a navigation task.

    Raises:
        BenchError: the task's variations are not exactly one course.
    """
    if len(task.variations) == 1 and isinstance(task.variations[0], Course):
        return task.variations[0]
    others = ", ".join(repr(variation) for variation in task.variations if not isinstance(variation, Course))
    message = f"A navigation task has exactly one course; its variations also include {others}."
    if not others:
        message = "A navigation task has exactly one course."
    raise BenchError("bad-course", message, task.id, "Variations of MuJoCo bodies do not apply to it.")


def check_render_mode(render_mode: str | None, task: Task) -> None:
    """Raises ``BenchError`` unless the render mode is ``"rgb_array"`` or None."""
    if render_mode not in (None, "rgb_array"):
        message = f"Navigation has no render mode {render_mode!r}."
        hint = WINDOW_HINT if render_mode == "human" else 'Use render_mode="rgb_array".'
        raise BenchError("unknown-render-mode", message, task.id, hint)


class Navigation(gym.Env[NDArray[Any], NDArray[np.float32]], IndependentCopies):
    """A point moves by small displacements over an occupancy grid to a goal.

    These are the 2-D navigation tasks of Henderson et al. 2017, "Benchmark Environments for Multitask
    Learning in Continuous Domains". The world has 640 × 480 units, cells of 10 × 10 units, and y up. The
    outermost ring of cells and everything outside are solid. There are ten maps with three goals each, in
    five families with different observations.

    **Action**: ``Box(-5, 5, (2,), float32)``, clipped to it.

    =====  ======================  ====  =========
    index  meaning                 unit  range
    =====  ======================  ====  =========
    0      displacement in x       unit  −5 to 5
    1      displacement in y       unit  −5 to 5
    =====  ======================  ====  =========

    **Motion**: the agent moves along a straight segment. If the segment touches an obstacle, the agent stays
    where it is; this is a collision. Cells are closed sets: a segment that touches an edge or a corner of an
    obstacle collides, so the agent cannot pass a diagonal gap.

    **Observation**, float32 except for the picture:

    ===========  ======  ======================================================  ====  ==============
    family       index   meaning                                                 unit  range
    ===========  ======  ======================================================  ====  ==============
    state        0, 1    x, y of the agent                                       unit  0–640, 0–480
    ..           2       distance to the closest obstacle, exact to its edge     unit  0–230
    ..           3       bearing to it, world frame; the least of several      rad   (−π, π]
    state-goal   0–3     as state                                                ..    ..
    ..           4, 5    x, y of the goal                                        unit  0–640, 0–480
    range        0–15    exact range at 22.5°·index, world frame; no hit is 100  unit  0–100
    range-known  0–15    as range                                                ..    ..
    ..           16, 17  x, y of the agent                                       unit  0–640, 0–480
    ..           18, 19  x, y of the goal                                        unit  0–640, 0–480
    image        all     picture (120, 160, 3), uint8, see below                 ..    0–255
    ===========  ======  ======================================================  ====  ==============

    A pixel of the picture is 4 × 4 units and shows what is at its center. The first row is at the top
    (largest y). Colors: free (255, 255, 255), obstacle (204, 153, 102), goal disc (255, 0, 0) of radius 20,
    and over it the agent disc (0, 0, 0) of radius 5. A range without a hit is 100.

    **Reward**: −1 per step, −5 more for a collision, +10 more for reaching the goal.

    **Start**: uniform over free space at least 100 units from the goal; ``reset(options={"start": (x, y)})``
    starts at any free point.

    **End**: terminated when the new position is within 20 units of the goal (distance ≤ 20); truncated after
    1000 steps by the time limit.

    **Success**: the step ends at the goal; ``info["is_success"]`` equals ``terminated``.

    **Versions**: v0 follows the paper's text. The 2017 code differs from the paper: polar actions, obstacles
    without effect, a start outside the map, +20 at the goal.

    Args:
        task: a task whose one variation is a ``Course``.
        render_mode: ``"rgb_array"`` (frames of 480 × 640 pixels) or None.
        custom_arena: a grid and goal to use instead of the course's.

    Raises:
        BenchError: the task is not a navigation task, or the render mode is not supported.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(self, task: Task, render_mode: str | None = None, custom_arena: Arena | None = None) -> None:
        check_render_mode(render_mode, task)
        row = course(task)
        self.task, self.render_mode = task, render_mode
        self.arena = arena(row.map, row.goal) if custom_arena is None else custom_arena
        self.observation_space = observation_space(row.family)
        self.action_space: gym.spaces.Space[Any] = action_space()
        self._world = World([self.arena], row.family)
        self._steps, self._is_set = 0, False
        self._moving = np.zeros(1, dtype=np.bool_)
        self._background: NDArray[np.uint8] | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Returns the first observation of an episode, and an empty dictionary.

        Args:
            seed: seed of the generator that draws starts; None continues with the generator.
            options: ``start``, a free point (x, y) in units, instead of a random one.

        Raises:
            BenchError: the start is not a free point. Nothing has changed then.
        """
        start = None
        if options and "start" in options:
            start = self._world.free_point(0, options["start"], self.task.id)
        super().reset(seed=seed)
        if start is None:
            self._world.draw_start(0, self.np_random)
        else:
            self._world.positions[0] = start
        self._steps, self._is_set = 0, True
        return self._world.observe()[0], {}

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Returns observation, reward, whether the goal is reached, False, and ``is_success`` as info.

        Raises:
            BenchError: the action's shape is not (2,), or a value is not finite.
            ResetNeededError: the environment was never reset.
        """
        require_reset(self._is_set, self.task.id)
        checked = check_actions(action, (2,), self.task.id)
        rewards, reached = self._world.advance(checked[None], self._moving)
        self._steps += 1
        arrived = bool(reached[0])
        return self._world.observe()[0], float(rewards[0]), arrived, False, {IS_SUCCESS: arrived}

    def save_state(self) -> state.State:
        """Returns ``position`` (2,) in units and ``steps`` () since reset, as float64 arrays.

        Raises:
            ResetNeededError: the environment was never reset.
        """
        require_reset(self._is_set, self.task.id)
        return {"position": self._world.positions[0].copy(), "steps": np.array(float(self._steps))}

    def restore_state(self, saved: Mapping[str, NDArray[np.float64]]) -> None:
        """Restores a saved state.

        The continuation is bit for bit the same.

        Raises:
            BenchError: a value is missing, unknown, not finite, or has another shape, the position is not
                free, or the steps are not a whole number. Nothing has changed then.
        """
        checked = state.check(saved, EXPECTED_STATE, self.task.id)
        steps = whole_steps(checked["steps"], self.task.id)
        self._world.place(0, checked["position"], self.task.id)
        self._steps, self._is_set = steps, True

    def render(self) -> NDArray[np.uint8] | None:
        """Returns a frame (480, 640, 3) with one pixel per unit, or None without a render mode."""
        if self.render_mode is None:
            gym.logger.warn(f"{self.task.id} was made without a render mode, so there is nothing to render.")
            return None
        require_reset(self._is_set, self.task.id)
        if self._background is None:
            self._background = background(self.arena, RENDER_PIXEL)
        return with_agent(self._background, self._world.positions[0], RENDER_PIXEL)
