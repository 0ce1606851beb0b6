"""Poses of an entry: which audited episodes are shown, and their replay."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.task import Task
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.sample import performance_cells
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import TRACE
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.trace_reader import (
    Array,
    RecordedEpisode,
    TraceRequest,
    read_trace,
    salt_in,
    trace_requests,
)
from gym_extensions.scoring.poses.model import (
    BODY_UNIT,
    MAP_UNIT,
    MAX_PATH_POINTS,
    MAX_SECONDS,
    RATE,
    Clip,
    Poses,
    TaskPoses,
    motion_of,
)
from gym_extensions.scoring.replay.motion import motions

Cell = tuple[int, str]
"""Stage and task id."""


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
        every = math.ceil(task.max_steps / MAX_PATH_POINTS)
        return Timing(MAP_UNIT, 0.0, float(every), task.max_steps)
    env: Any = construct_mujoco(task)
    rate = 1 / float(env.dt)
    return Timing(BODY_UNIT, rate, rate / RATE, math.ceil(MAX_SECONDS * rate))


def shown_episodes(folder: Folder, log: Log) -> dict[Cell, TraceRequest]:
    """The audited episode of the first run that is shown, by stage and task.

    The cells are those right after the training on a task and at the end. Of the two audited episodes of a
    cell, the drawn one is shown and not the one with the largest return.
    """
    salt, tasks = salt_in(folder, log.group.name), log.group.tasks
    shown: dict[Cell, TraceRequest | None] = dict.fromkeys(performance_cells(log.protocol, tasks))
    for request in sorted(trace_requests(log, folder.read(log.path), salt), key=lambda each: -each.return_):
        run, stage, _ = _numbers(request)
        if run == log.runs[0] and (stage, request.task.id) in shown:
            shown[stage, request.task.id] = request
    return {cell: request for cell, request in shown.items() if request is not None}


def episode_of(request: TraceRequest) -> int:
    """The number of the episode in its cell."""
    return _numbers(request)[2]


def _numbers(request: TraceRequest) -> tuple[int, int, int]:
    """Run, stage and episode, from the name of the trace."""
    match = TRACE.fullmatch(request.path.rpartition("/")[2])
    if match is None:
        raise BenchError("bad-trace-name", "The name of the trace is not in the format.", request.path)
    return int(match[2]), int(match[3]), int(match[5])


def poses_of(folder: Folder, log: Log) -> Poses:
    """The poses of the first run of a sequential log.

    Raises:
        BenchError: the log has no traces, one is missing or malformed, or its replay differs.
    """
    shown = shown_episodes(folder, log)
    if not shown:
        raise BenchError("no-traces", "The log has no audited traces.", log.path, "Record it again.")
    episodes = {cell: _episode(folder, request) for cell, request in shown.items()}
    clips: dict[Cell, Clip] = {}
    timings = {task.id: timing_of(task) for task in log.group.tasks}
    for task in log.group.tasks:
        timing = timings[task.id]
        cells = [cell for cell in shown if cell[1] == task.id]
        tracks = motions(task, [episodes[cell] for cell in cells], timing.most_steps)
        for cell, track in zip(cells, tracks, strict=True):
            frames = frames_of(track, timing)
            clips[cell] = _clip(log, cell, shown[cell], frames, timing.unit)
    last = len(log.group.tasks)
    return Poses(
        submission=folder.name,
        group=log.group.id,
        run=log.runs[0],
        tasks=tuple(
            TaskPoses(
                task=task.id,
                after=clips[stage, task.id],
                end=None if stage == last else clips[last, task.id],
                unit=timings[task.id].unit,
                steps_per_second=timings[task.id].steps_per_second,
                steps_per_frame=timings[task.id].steps_per_frame,
            )
            for stage, task in enumerate(log.group.tasks, start=1)
        ),
    )


def frames_of(track: Array, timing: Timing) -> Array:
    """The coordinates at the frames, interpolated between steps; the last is within a frame of the end."""
    count = math.floor((len(track) - 1) / timing.steps_per_frame + 1e-9) + 1
    at = np.arange(count) * timing.steps_per_frame
    if timing.steps_per_second == 0:
        at = np.append(at, len(track) - 1) if at[-1] < len(track) - 1 else at
    steps = np.arange(len(track))
    return np.stack([np.interp(at, steps, column) for column in track.T], axis=1)


def _episode(folder: Folder, request: TraceRequest) -> RecordedEpisode:
    trace = read_trace(folder, request)
    if isinstance(trace, Problem):
        raise BenchError(trace.rule, trace.message, trace.where, trace.hint)
    return trace


def _clip(log: Log, cell: Cell, request: TraceRequest, frames: Array, unit: float) -> Clip:
    stage, task_id = cell
    rows = (
        (log.run == log.runs[0]) & (log.stage == stage) & (log.position == log.group.task_ids.index(task_id))
    )
    returns = log.return_[rows]
    if len(returns) != EVALUATION_EPISODES:
        raise BenchError("missing-cell", f"The cell has {len(returns)} episodes.", log.path)
    return Clip(
        stage=stage,
        episode=episode_of(request),
        steps=request.length,
        success=request.success,
        returns=tuple(round(value, 2) for value in returns[np.argsort(log.episode[rows])].tolist()),
        frames=len(frames),
        motion=motion_of(frames, unit),
    )
