"""Navigation: many agents in one world, and the single and the vector environment."""

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from gym_extensions.catalog import bodies, variations
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import interfaces
from gym_extensions.envs.interfaces import Array, Flags
from gym_extensions.envs.navigation import sensors
from gym_extensions.envs.navigation.geometry import Arena, advance, arena, touches
from gym_extensions.envs.vector_env import WHERE, Part, TaskVectorEnv
from gym_extensions.errors import BenchError

RENDER_PIXEL = 1.0
"""Side of a pixel of a rendered frame, in units."""


def course(task: Task) -> variations.Course:
    """Returns the course of a navigation task.

    Raises ``BenchError`` if the task's variations are not exactly one course.
    """
    if len(task.variations) == 1 and isinstance(task.variations[0], variations.Course):
        return task.variations[0]
    message = f"A navigation task has one course and no other variation; it has {list(task.variations)}."
    raise BenchError("bad-course", message, task.id, "Variations of MuJoCo bodies do not apply to it.")


START_CLEARANCE = 100.0
"""Smallest distance of a random start from the goal, in units."""


class World:
    """The positions of many agents and what they observe, which is a key of the catalog's ``FAMILIES``.

    ``arenas`` are the grid and the goal of each agent; all grids have the same size.
    """

    def __init__(self, arenas: Sequence[Arena], family: str) -> None:
        self.arenas, self.family = tuple(arenas), family
        self.positions = np.full((len(arenas), 2), np.nan)
        self._goals = np.array([arena.goal for arena in arenas], dtype=np.float64)
        grids = list(dict.fromkeys(arena.grid for arena in arenas))
        self._solids = np.stack([grid.solid for grid in grids])
        self._map_of = np.array([grids.index(arena.grid) for arena in arenas])
        if family == "image":
            distinct = list(dict.fromkeys(arenas))
            self._backgrounds = np.stack([sensors.background(arena, sensors.PIXEL) for arena in distinct])
            self._background_of = np.array([distinct.index(arena) for arena in arenas])
        else:
            width = sum(field.count for field in sensors.FIELDS[family])
            self._numbers = np.zeros((len(arenas), width), dtype=np.float32)
            if family in ("state-goal", "range-known"):
                self._numbers[:, -2:] = self._goals  # they never change

    def advance(self, actions: NDArray[Any], resting: Flags | None = None) -> tuple[Array, Flags]:
        """Moves every agent that is not ``resting`` (agents,); returns rewards and arrivals, (agents,) each.

        ``actions`` (agents, 2) are displacements in units, clipped here. Resting agents get reward 0.
        """
        moves = np.ascontiguousarray(actions, dtype=np.float64)
        if resting is None:
            resting = np.zeros(len(moves), np.bool_)
        return advance(self._solids, self._map_of, self._goals, self.positions, moves, resting)

    def observe(self) -> NDArray[Any]:
        """Returns every agent's observation, (agents, …). Every agent has been placed."""
        if self.family == "image":
            pictures = self._backgrounds[self._background_of]
            sensors.draw_agents(pictures, self.positions, sensors.PIXEL)
            return pictures
        numbers = self._numbers
        if self.family.startswith("range"):
            sensors.cast_ranges(self._solids, self._map_of, self.positions, numbers)
            if self.family == "range-known":
                numbers[:, sensors.BEAMS : sensors.BEAMS + 2] = self.positions
        else:
            numbers[:, :2] = self.positions
            sensors.find_nearest(self._solids, self._map_of, self.positions, numbers)
        return numbers.copy()

    def draw_start(self, agent: int, generator: np.random.Generator) -> None:
        """Places an agent uniformly over the free space that is far enough from its goal."""
        size, goal = self.arenas[agent].grid.size, self._goals[agent]
        while True:
            x, y = generator.uniform((0.0, 0.0), size)
            far = np.hypot(x - goal[0], y - goal[1]) >= START_CLEARANCE
            if far and not touches(self.arenas[agent].grid.solid, x, y):
                self.positions[agent] = x, y
                return


class Navigation(gym.Env[NDArray[Any], NDArray[np.float32]]):
    """A point moves by small displacements over an occupancy grid to a goal.

    The world has 640 × 480 units, cells of 10 × 10 units, and y up. The outermost ring of cells and
    everything outside are solid.

    The action is a displacement in x and y, clipped to ±5. The agent moves along a straight segment. If the
    segment touches an obstacle, the agent stays where it is; this is a collision. Cells are closed sets: a
    segment that touches an edge or a corner of an obstacle collides, so the agent cannot pass a diagonal gap.
    Observations are in ``sensors``, reward, start and end in ``catalog/prose.toml``.

    The tasks follow the text of Henderson et al. 2017. Their code differs from it: polar actions, obstacles
    without effect, a start outside the map, +20 at the goal.

    Args:
        task: a task whose one variation is a ``Course``.
        render_mode: ``"rgb_array"`` (frames of 480 × 640 pixels) or None.

    Raises ``BenchError`` if the task is not a navigation task, or the render mode is not supported.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(self, task: Task, render_mode: str | None = None) -> None:
        if render_mode not in (None, "rgb_array"):
            message = f"Navigation has no render mode {render_mode!r}."
            raise BenchError("unknown-render-mode", message, task.id, 'Use "rgb_array" or "human".')
        found = course(task)
        self.task, self.render_mode = task, render_mode
        self.arena = arena(found.map, found.goal)
        self.observation_space = sensors.observation_space(found.family)
        self.action_space: gym.spaces.Space[Any] = sensors.action_space()
        self._world = World([self.arena], found.family)
        self._is_set = False
        self._background: NDArray[np.uint8] | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Returns the first observation of an episode, and an empty dictionary. There are no options."""
        super().reset(seed=seed)
        self._world.draw_start(0, self.np_random)
        self._is_set = True
        return self._world.observe()[0], {}

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Returns observation, reward, whether the goal is reached, False, and ``is_success`` as info.

        Raises:
            BenchError: the action's shape is not (2,), or a value is not finite.
            ResetNeededError: the environment was never reset.
        """
        interfaces.require_reset(self._is_set, self.task.id)
        checked = interfaces.check_actions(action, (2,), self.task.id)
        rewards, reached = self._world.advance(checked[None])
        arrived = bool(reached[0])
        return self._world.observe()[0], float(rewards[0]), arrived, False, {bodies.IS_SUCCESS: arrived}

    @property
    def position(self) -> Array:
        """A copy of the agent's position, (2,), in units. Raises ``ResetNeededError`` before a reset."""
        interfaces.require_reset(self._is_set, self.task.id)
        return self._world.positions[0].copy()

    def render(self) -> NDArray[np.uint8] | None:
        """Returns a frame (480, 640, 3) with one pixel per unit, or None without a render mode."""
        if self.render_mode is None:
            gym.logger.warn(f"{self.task.id} was made without a render mode, so there is nothing to render.")
            return None
        interfaces.require_reset(self._is_set, self.task.id)
        if self._background is None:
            self._background = sensors.background(self.arena, RENDER_PIXEL)
        frame = self._background[None].copy()
        sensors.draw_agents(frame, self._world.positions, RENDER_PIXEL)
        return frame[0]


class NavigationVectorEnv(TaskVectorEnv):
    """Navigation environments of one family, with many agents in one compiled world, each alone in its arena.

    Raises ``BenchError`` if the tasks belong to several families, or one is not a navigation task.
    """

    def __init__(
        self, tasks: Sequence[Task], autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP
    ) -> None:
        courses = [course(task) for task in tasks]
        families = sorted({each.family for each in courses})
        if len(families) > 1:
            message = f"The tasks have different observations: {', '.join(families)}."
            raise BenchError("different-spaces", message, WHERE, "Give tasks of one navigation family.")
        super().__init__(
            tasks, (sensors.observation_space(families[0]), sensors.action_space()), autoreset_mode
        )
        self._world = World([arena(each.map, each.goal) for each in courses], families[0])
        self._arrivals = np.zeros(len(tasks), np.bool_)

    def _start(self, chosen: Flags) -> None:
        for index in np.flatnonzero(chosen).tolist():
            self._world.draw_start(index, self._generator(index))

    def _advance(self, actions: NDArray[Any], resting: Flags | None) -> tuple[Array, Flags]:
        rewards, self._arrivals = self._world.advance(actions, resting)
        return rewards, self._arrivals

    def _observe(self) -> NDArray[Any]:
        return self._world.observe()

    def _step_infos(self) -> list[Part]:
        return [(np.arange(self.num_envs), {bodies.IS_SUCCESS: self._arrivals.copy()})]

    def states(self) -> dict[str, Array]:
        self._require_state()
        return {"position": self._world.positions.copy()}
