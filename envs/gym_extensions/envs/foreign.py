"""Environments of other packages as tasks: what they return is made regular, and what is broken is named."""

import time
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

import gymnasium as gym
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import IS_SUCCESS
from gym_extensions.catalog.tasks import Task
from gym_extensions.errors import BenchError

CODE, SEED = "bad-environment", 0
HINT = "Correct the environment, or register it with a wrapper that does."
SEEDS = "Call super().reset(seed=seed), and draw every random number from self.np_random."
CHECK_STEPS, CHECK_SECONDS = 200, 1.0
"""The longest episode of the check of a task, and the time for all episodes."""
TOLERANCE = 1e-4
"""How far an observation may lie outside its space, absolute and relative to the bound: rounding."""
REWARD = Box(-np.inf, np.inf, (1,), np.float64)


class ForeignEnv(gym.Wrapper[Any, Any, Any, Any]):
    """An environment of another package. It reports no success, because its task defines none.

    Observations are new arrays of the type of their space, rewards and ends are plain numbers.

    Raises ``BenchError`` if the environment raises an error, returns another number of values, or a value
    that is not finite or has another shape. It names the task, the step of the episode and the action.
    """

    def __init__(self, env: gym.Env[Any, Any], task: Task) -> None:
        super().__init__(env)
        self.task, self._steps = task, 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        self._steps = 0
        observation, info = self._called("reset()", 2, self.env.reset, seed=seed, options=options)
        return self._array("observation", observation, self.observation_space, "reset()"), info

    def step(self, action: Any) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        self._steps += 1
        where = f"step {self._steps} of an episode, with the action {np.asarray(action).tolist()},"
        observation, reward, *ends, info = self._called(where, 5, self.env.step, action)
        seen = self._array("observation", observation, self.observation_space, where)
        (value,) = self._array("reward", np.ravel(reward), REWARD, where).tolist()
        terminated, truncated = (bool(np.any(each)) for each in ends)
        return seen, value, terminated, truncated, {key: info[key] for key in info if key != IS_SUCCESS}

    def _called(self, where: str, size: int, method: Any, *arguments: Any, **options: Any) -> Any:
        try:
            returned = method(*arguments, **options)
        except (BenchError, gym.error.Error):
            raise
        except Exception as error:  # noqa: BLE001  (the environment may raise anything)
            self.fail(f"{where} raised {type(error).__name__}: {error}".rstrip(" .:"), cause=error)
        if not isinstance(returned, tuple) or len(returned) != size:
            shown = f"{len(returned)} values" if isinstance(returned, tuple) else type(returned).__name__
            self.fail(f"{where} returned {shown}; expected {size} values, as in Gymnasium 1")
        if not isinstance(returned[-1], dict):
            self.fail(f"{where} returned the info {returned[-1]!r}; expected a dictionary")
        return returned

    def _array(self, name: str, value: Any, space: Any, where: str) -> NDArray[Any]:
        try:
            array = np.array(value, space.dtype)  # a copy: many environments change one array of their own
            is_same = array.dtype.kind == "f" or np.array_equal(array, value)
        except (TypeError, ValueError, OverflowError):
            is_same = False
        if not is_same:
            self.fail(f"{where} returned the {name} {value!r}, which is not made of {space.dtype} numbers")
        if array.shape != space.shape:
            self.fail(f"{where} returned the {name} of shape {array.shape}; expected {space.shape}")
        if not np.isfinite(array).all():
            self.fail(f"{where} returned the {name} {array[~np.isfinite(array)][0]}")
        return array

    def fail(self, message: str, hint: str = HINT, cause: Exception | None = None) -> NoReturn:
        """Raises the ``BenchError`` of this environment."""
        text = f"The environment {self.task.base} is broken: {message}."
        raise BenchError(CODE, text, self.task.id, hint) from cause


def build(task: Task, **rendering: Any) -> ForeignEnv:
    """The environment with the wrappers of its registration and the time limit of the task.

    Raises ``BenchError`` if it cannot be made, or has spaces that agents and policies do not support.
    """
    given = {name: value for name, value in rendering.items() if value is not None}  # it may know none
    try:
        env = gym.make(task.base, task.max_steps, disable_env_checker=True, **given)
    except Exception as error:
        if given:
            raise
        message = f"It cannot be made: {type(error).__name__}: {error}".rstrip(" .:")
        raise BenchError(CODE, f"{message}.", task.id, HINT) from error
    for name in ("observation_space", "action_space"):
        space = getattr(env, name)
        is_fit = isinstance(space, Box) and space.shape != ()
        if is_fit and name == "action_space":
            width = space.high - space.low
            is_fit = space.dtype.kind == "f" and width.ndim == 1 and all((width > 0) & (width < np.inf))
        if not is_fit:
            env.close()
            hint = "Wrap it: both are a Box with axes, that of actions a vector of bounded floats."
            raise BenchError("bad-space", f"Its {name} is {space}.", task.id, hint)
    return ForeignEnv(env, task)


def check(tasks: Sequence[Task]) -> None:
    """Runs seeded episodes of random actions in environments of other packages, before anything is trained.

    Two episodes of one environment and one of a new one have the same seed and actions: they have to be
    equal, finite and in the observation space. All together take about ``CHECK_SECONDS``.

    Raises ``BenchError`` that names the task and the first step that is not.
    """
    differing = f"two episodes with the seed {SEED} and the same actions differ"
    for task in tasks:
        with build(task) as first, build(task) as second:
            seconds = CHECK_SECONDS / len(tasks) / 3
            recorded = list(_episode(first, seconds))
            for env in (first, second):
                again = zip(recorded, _episode(env, seconds), strict=False)  # slow episodes are cut
                for step, (row, other) in enumerate(again):
                    if not all(map(np.array_equal, row, other)):
                        first.fail(f"{differing} at step {step}", SEEDS)


def _episode(env: ForeignEnv, seconds: float) -> Iterator[tuple[Any, ...]]:
    """The observation of a reset and the rows of random steps, the first of them in any case."""
    space: Any = env.observation_space
    until = time.monotonic() + seconds
    env.action_space.seed(SEED)
    row: tuple[Any, ...] = (env.reset(seed=SEED)[0], 0.0, False, False)
    for step in range(CHECK_STEPS):
        if not np.allclose(row[0], np.clip(row[0], space.low, space.high), TOLERANCE, TOLERANCE):
            env.fail(f"the observation at step {step} lies outside of {space}")
        yield row
        if row[2] or row[3] or (step and time.monotonic() > until):
            return
        row = env.step(env.action_space.sample())[:4]
