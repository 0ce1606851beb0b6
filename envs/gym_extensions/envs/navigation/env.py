"""The single environment: the world with one agent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.maps import Course
from gym_extensions.envs import state
from gym_extensions.envs.actions import check_actions
from gym_extensions.envs.navigation.grid import Arena, arena
from gym_extensions.envs.navigation.observations import action_space, observation_space
from gym_extensions.envs.navigation.rendering import background, with_agent
from gym_extensions.envs.navigation.simulation import World
from gym_extensions.envs.navigation.viewer import Window
from gym_extensions.errors import BenchError, did_you_mean

RENDER_PIXEL = 1.0
"""Side of a pixel of a rendered frame, in units."""


def course(task: Task) -> Course:
    """What a navigation task is made of.

    Raises:
        BenchError: the task holds anything beside one course.
    """
    if len(task.variations) == 1 and isinstance(task.variations[0], Course):
        return task.variations[0]
    others = ", ".join(repr(variation) for variation in task.variations if not isinstance(variation, Course))
    message = (
        f"A navigation task is one course and nothing else; there is also: {others or 'no single course'}."
    )
    raise BenchError("bad-course", message, task.id, "Variations of bodies do not apply to it.")


class Navigation(gym.Env[NDArray[Any], NDArray[np.float32]], EzPickle):
    """A point finds its way over an occupancy grid to a goal, by small displacements.

    Henderson et al. 2017, "Benchmark Environments for Multitask Learning in Continuous Domains", the 2-D
    navigation tasks. World: 640 × 480 units, cells of 10 × 10, y up; the outermost ring of cells and all
    outside is solid. Ten maps with three goals each, in five families that differ in what is observed.

    **Action**: ``Box(-5, 5, (2,), float32)``, clipped to it.

    =====  ======================  ====  =========
    index  meaning                 unit  range
    =====  ======================  ====  =========
    0      displacement in x       unit  −5 to 5
    1      displacement in y       unit  −5 to 5
    =====  ======================  ====  =========

    **Motion**: the straight segment to the new position is free, or the agent stays where it is: a collision.
    Cells
    are closed sets: a segment that meets an edge or a corner of an obstacle collides, so a diagonal gap is
        closed.

    **Observation**, float32 but for the picture:

    ===========  ======  ======================================================  ====  ==============
    family       index   meaning                                                 unit  range
    ===========  ======  ======================================================  ====  ==============
    state        0, 1    x, y of the agent                                       unit  0–640, 0–480
    ..           2       distance to the closest obstacle, exact to its edge     unit  0–230
    ..           3       bearing to it, world frame; of equally close the least  rad   (−π, π]
    state-goal   0–3     as state                                                ..    ..
    ..           4, 5    x, y of the goal                                        unit  0–640, 0–480
    range        0–15    exact range at 22.5°·index, world frame; no hit is 100  unit  0–100
    range-known  0–15    as range                                                ..    ..
    ..           16, 17  x, y of the agent                                       unit  0–640, 0–480
    ..           18, 19  x, y of the goal                                        unit  0–640, 0–480
    image        all     picture (120, 160, 3), uint8, see below                 ..    0–255
    ===========  ======  ======================================================  ====  ==============

    A pixel of the picture shows what lies at its centre, 4 units a pixel, the first row at the top (largest
    y): free (255, 255, 255), obstacle (204, 153, 102), goal disc (255, 0, 0) of radius 20, agent disc (0, 0,
    0) of radius 5 over it. Ranges that hit nothing read 100, as does a hit at 100.

    **Reward**: −1 every step, a further −5 on a collision, a further +10 on reaching the goal.

    **Start**: uniform over free space at least 100 units from the goal; ``reset(options={"start": (x, y)})``
    starts at any free point.

    **End**: terminated when the new position is within 20 units of the goal (distance ≤ 20); truncated after
    1000 steps by the time limit.

    **Versions**: v0, the paper's text. The 2017 code departs from it (polar actions, obstacles without
    effect, a start outside the map, +20 at the goal); this follows the paper.

    Args:
        task: a task whose one variation is a ``Course``.
        render_mode: ``"rgb_array"`` (frames of 480 × 640 pixels), ``"human"`` (a window) or None.
        place: another grid and goal than the course's, for experiments.

    Raises:
        BenchError: the task is no navigation task, or the render mode is unknown.
    """

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(self, task: Task, render_mode: str | None = None, place: Arena | None = None) -> None:
        EzPickle.__init__(self, task, render_mode, place)
        modes = self.metadata["render_modes"]
        if render_mode is not None and render_mode not in modes:
            hint = did_you_mean(render_mode, modes)
            raise BenchError(
                "unknown-render-mode", f"There is no render mode {render_mode!r}.", task.id, hint
            )
        drawn = course(task)
        self.task, self.render_mode = task, render_mode
        self.arena = arena(drawn.map, drawn.goal) if place is None else place
        self.observation_space = observation_space(drawn.family)
        self.action_space: gym.spaces.Space[Any] = action_space()
        self._world = World([self.arena], drawn.family)
        self._steps = 0
        self._moving = np.zeros(1, dtype=np.bool_)
        self._background: NDArray[np.uint8] | None = None
        self._window = Window(task.name)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """The first observation of an episode, and an empty dictionary.

        Args:
            seed: of the generator that draws starts; None goes on with it.
            options: ``start``, a free point (x, y) in units, in place of a drawn one.

        Raises:
            BenchError: the start is not a free point.
        """
        super().reset(seed=seed)
        if options and "start" in options:
            self._world.place(0, options["start"], self.task.id)
        else:
            self._world.draw_start(0, self.np_random)
        self._steps = 0
        self._show()
        return self._world.observe()[0], {}

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Observation, reward, whether the goal is reached, False, and an empty dictionary.

        Raises:
            BenchError: the action has another shape than (2,) or a value that is not finite.
        """
        given = check_actions(action, (2,), self.task.id)
        rewards, reached = self._world.advance(given[None], self._moving)
        self._steps += 1
        self._show()
        return self._world.observe()[0], float(rewards[0]), bool(reached[0]), False, {}

    def save_state(self) -> state.State:
        """The ``position`` (2,) in units and the ``steps`` so far () between two steps, as float64 arrays."""
        return {"position": self._world.positions[0].copy(), "steps": np.array(float(self._steps))}

    def restore_state(self, saved: Mapping[str, NDArray[np.float64]]) -> None:
        """Puts a saved state back: what follows is bit for bit what followed when it was saved.

        Raises:
            BenchError: a value is missing, unknown, of another shape or not finite, or the position is not
            free.
        """
        checked = state.check(saved, self.save_state(), self.task.id)
        self._world.place(0, checked["position"], self.task.id)
        self._steps = int(checked["steps"])

    def render(self) -> NDArray[np.uint8] | None:
        """A frame (480, 640, 3) in mode ``rgb_array``, a pixel a unit; None otherwise."""
        if self.render_mode is None:
            gym.logger.warn(f"{self.task.id} was made without render_mode: there is nothing to render.")
            return None
        frame = self._frame()
        if self.render_mode == "rgb_array":
            return frame
        self._window.show(frame, self.metadata["render_fps"])
        return None

    def close(self) -> None:
        """Closes the window, if there is one."""
        self._window.close()

    def _frame(self) -> NDArray[np.uint8]:
        if self._background is None:
            self._background = background(self.arena, RENDER_PIXEL)
        return with_agent(self._background, self._world.positions[0], RENDER_PIXEL)

    def _show(self) -> None:
        if self.render_mode == "human":
            self.render()
