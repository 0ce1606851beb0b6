"""The loop that runs a policy or an agent on given seeds, one episode per environment."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import IS_SUCCESS
from gym_extensions.envs.interfaces import Flags
from gym_extensions.errors import BenchError

Act = Callable[[NDArray[Any], Flags, Flags], Any]
"""``act(observations, starts, running)`` gives actions (num_envs, …), which need not be clipped.

``starts`` (num_envs,) marks observations that are the first of an episode. ``running`` (num_envs,) marks the
environments whose first episode has not ended; the actions of the others have no effect on any result.
"""
Watch = Callable[[NDArray[Any] | None], None]
"""Called after the reset with None, and after every step with the applied actions (num_envs, …)."""


class Outcome(NamedTuple):
    """The end of an episode, as a row of a log states it.

    ``return_`` is the sum of all rewards (``math.fsum``). ``success`` is the ``is_success`` of the last step,
    None where the task defines none.
    """

    length: int
    return_: float
    terminated: bool
    success: bool | None


def run_episodes(
    env: VectorEnv[Any, Any, Any],
    seeds: Sequence[int],
    act: Act,
    *,
    watch: Watch | None = None,
    where: str = "act()",
) -> list[Outcome]:
    """Runs the first episode of every environment.

    An environment whose episode ended is stepped on until the last of these episodes ends, so that no action
    depends on when another episode ended. A deterministic policy of plain arrays then repeats logged episodes
    bit for bit.

    Args:
        env: ``len(seeds)`` environments of one task, with autoreset mode NEXT_STEP.
        seeds: the reset seed of each environment.
        act: gives the actions. They are checked, clipped to the action space and cast to its dtype.
        watch: called after the reset and after every step, for example to save states.
        where: what to name in an error about actions.

    Returns:
        One outcome per seed, in the order of ``seeds``.

    Raises:
        BenchError: the actions are not an array of numbers of shape (num_envs, …), or an action of a running
            episode is not finite.
    """
    observations, _ = env.reset(seed=list(seeds))  # type: ignore[arg-type]
    if watch is not None:
        watch(None)
    rewards: list[list[float]] = [[] for _ in seeds]
    outcomes: dict[int, Outcome] = {}
    running, starts = np.ones(len(seeds), np.bool_), np.ones(len(seeds), np.bool_)
    resetting = np.zeros(len(seeds), np.bool_)
    while running.any():
        actions = clip_actions(act(observations, starts, running.copy()), env, where, running)
        observations, reward, terminated, truncated, infos = env.step(actions)
        if watch is not None:
            watch(actions)
        starts, resetting = resetting, terminated | truncated
        for index in np.flatnonzero(running).tolist():
            rewards[index].append(float(reward[index]))
            if resetting[index]:
                is_defined = IS_SUCCESS in infos and infos[f"_{IS_SUCCESS}"][index]
                success = bool(infos[IS_SUCCESS][index]) if is_defined else None
                result = len(rewards[index]), math.fsum(rewards[index]), bool(terminated[index])
                outcomes[index] = Outcome(*result, success)
                running[index] = False
    return [outcomes[index] for index in range(len(seeds))]


def clip_actions(
    actions: Any, env: VectorEnv[Any, Any, Any], where: str, running: Flags | None = None
) -> NDArray[Any]:
    """Clips actions (num_envs, …) to the action space and casts them to its dtype (float32).

    ``running`` (num_envs,) marks the environments whose actions must be finite; None for all.

    Raises:
        BenchError: the actions are not an array of numbers of shape (num_envs, …), or one is not finite. It
            names ``where`` they come from.
    """
    space: Any = env.single_action_space
    shape = (env.num_envs, *(space.shape or ()))
    try:
        # A tensor of PyTorch may be on another device, or be part of a graph.
        array = np.asarray(actions.detach().cpu() if hasattr(actions, "detach") else actions)
    except (TypeError, ValueError, RuntimeError):  # a ragged list
        array = None
    if array is None or array.dtype.kind not in "biuf" or array.shape != shape:
        shown = f"a value of type {type(actions).__name__}"
        if array is not None and array.shape:
            shown = f"an array of shape {array.shape} and dtype {array.dtype}"
        message = f"The agent returned {shown} as actions."
        hint = f"Return an array of numbers of shape {shape}, one row per environment."
        raise BenchError("bad-actions", message, where, hint)
    is_finite = np.isfinite(array)
    if not is_finite.all():
        required = np.ones(env.num_envs, np.bool_) if running is None else running
        for index in map(tuple, np.argwhere(~is_finite).tolist()):
            if required[index[0]]:
                row = f"in the row of environment {index[0]}"
                message = f"The agent returned {array[index]} as an action, {row}."
                raise BenchError("bad-actions", message, where, "Return finite numbers.")
        array = np.nan_to_num(array)
    low, high = getattr(space, "low", None), getattr(space, "high", None)
    return array if low is None else np.clip(array, low, high).astype(space.dtype, copy=False)
