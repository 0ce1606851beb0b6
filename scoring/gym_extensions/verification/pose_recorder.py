"""Poses of a submission: episodes of the stored policies, run again while their coordinates are recorded."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.tasks import Task
from gym_extensions.documents import filled
from gym_extensions.envs import fingerprinting, rollout
from gym_extensions.envs.mujoco.env import TaskEnv
from gym_extensions.submissions import poses as store
from gym_extensions.submissions.fetch import Fetcher
from gym_extensions.submissions.policies.files import AnyPolicy
from gym_extensions.verification import limits
from gym_extensions.verification.episodes import Cell, RunRequest, limits_of, run_cell, stored_policies
from gym_extensions.verification.logged_run import LoggedRun

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Timing:
    """How an episode becomes frames. ``steps_per_second`` is 0 in 2-D navigation."""

    unit: float
    steps_per_second: float
    steps_per_frame: float
    most_steps: int


def timing_of(task: Task) -> Timing:
    """15 frames per second of the first ten seconds, or a path of at most 250 points."""
    if task.body.family == "navigation":
        every = math.ceil(task.max_steps / store.MAX_PATH_POINTS)
        return Timing(store.MAP_UNIT, 0.0, float(every), task.max_steps)
    env: Any = TaskEnv(task)
    rate = 1 / float(env.dt)
    env.close()
    return Timing(store.BODY_UNIT, rate, rate / store.RATE, math.ceil(store.MAX_SECONDS * rate))


def frames_of(track: Array, timing: Timing) -> Array:
    """The coordinates at the frames, interpolated between steps; the last is within a frame of the end.

    The track (steps + 1, n) has the coordinates after the reset and after every step.
    """
    count = math.floor((len(track) - 1) / timing.steps_per_frame + 1e-9) + 1
    at = np.arange(count) * timing.steps_per_frame
    if timing.steps_per_second == 0:
        at = np.append(at, len(track) - 1) if at[-1] < len(track) - 1 else at
    steps = np.arange(len(track))
    return np.stack([np.interp(at, steps, column) for column in track.T], axis=1)


def shown_episode(returns: list[float]) -> int:
    """The episode of a cell that is shown: that of the median return, the lower one of two."""
    return int(np.argsort(returns, kind="stable")[(len(returns) - 1) // 2])


def coordinates(states: Mapping[str, Any], episode: int) -> Array:
    """``qpos`` and the x and y of mocap bodies (a wall, a goal), or the position on the map."""
    if "position" in states:
        return np.array(states["position"][episode])
    mocap = [states["mocap_pos"][episode, 0, :2]] if "mocap_pos" in states else []
    return np.concatenate([states["qpos"][episode], *mocap])


def record(call: Mapping[str, Any]) -> Iterator[Any]:
    """The job of the process with limits: the motion in each cell of a run, in the order of the cells."""
    request = msgspec.convert(call["run"], RunRequest)
    group = GROUPS[request.group]
    policies = stored_policies(request, group)
    for cell, episode in zip(request.cells, call["episodes"], strict=True):
        timing = timing_of(group.tasks[cell.task])
        outcomes, tracks = recorded(group, policies[request.key(group, cell)], cell, timing)
        yield motion(tracks[episode], outcomes[episode], timing)


def recorded(
    group: TaskGroup, policy: AnyPolicy, cell: Cell, timing: Timing
) -> tuple[list[rollout.Outcome], list[list[Array]]]:
    """The outcomes of a cell, and the coordinates of each episode after the reset and every shown step."""
    fingerprinting.require_published_engine()
    tracks: list[list[Array]] = [[] for _ in cell.seeds]

    def watch(env: Any, _: Any) -> None:
        if len(tracks[0]) <= timing.most_steps:
            states = env.states()
            for episode, track in enumerate(tracks):
                track.append(coordinates(states, episode))

    return run_cell(group, policy, cell, watch), tracks


def motion(track: Sequence[Array], outcome: rollout.Outcome, timing: Timing) -> dict[str, Any]:
    """The fields of an episode's clip that follow from its coordinates after the reset and every step."""
    frames = frames_of(np.stack(track[: outcome.length + 1]), timing)
    facts = {"steps": outcome.length, "success": outcome.success, "frames": len(frames)}
    return {**facts, "motion": store.motion_of(frames, timing.unit)}


def poses_of(run: LoggedRun, fetcher: Fetcher) -> store.Poses:
    """The poses of a sequential run: an episode of every task right after its training and at the end.

    Policies that sample their actions are shown in an episode of their own, from the same start. Raises
    ``BenchError`` if the policies cannot be run.
    """
    group = run.log.group
    last = len(group.tasks)
    keys = sorted({key for index in range(last) for key in ((index + 1, index), (last, index))})
    cells = [run.prescribed_cell(*key) for key in keys]
    if run.submission.is_sampled:
        cells = [replace(cell, noise=cell.seeds[0]) for cell in cells]
    request = run.request(cells, fetcher)
    returns = {key: [outcome.return_ for outcome in run.logged[key]] for key in keys}
    episodes = [shown_episode(returns[key]) for key in keys]
    call = {"run": msgspec.to_builtins(request), "episodes": episodes}
    clips: dict[tuple[int, int], store.Clip] = {}
    found = limits.answers(record, call, limits_of([request]))
    for key, episode, values in zip(keys, episodes, found, strict=True):
        rounded = tuple(round(value, 2) for value in returns[key])
        clips[key] = store.Clip(stage=key[0], episode=episode, returns=rounded, **values)
    tasks = []
    for index, task in enumerate(group.tasks):
        end = None if index + 1 == last else clips[last, index]
        own = {"task": task.id, "after": clips[index + 1, index], "end": end}
        tasks.append(filled(store.TaskPoses, timing_of(task), **own))
    return store.Poses(
        submission=run.submission.name, group=group.id, run=run.document.run, tasks=tuple(tasks)
    )
