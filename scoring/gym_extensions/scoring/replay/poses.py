"""Poses of an entry: which audited episodes are shown, and their replay."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.task import Task
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.audit import Audited
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.trace_reader import (
    Array,
    RecordedEpisode,
    read_trace,
    sample_of,
    trace_path,
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


def shown_episodes(log: Log, data: bytes, files: dict[str, object], run: int) -> list[Audited]:
    """The audited episodes of a run that are shown: the first of each audited cell, sorted."""
    first: dict[tuple[int, str], Audited] = {}
    for audited in sample_of(log, data, files):
        if audited.run == run:
            first.setdefault((audited.stage, audited.task), audited)
    return list(first.values())


def poses_of(folder: Folder, log: Log) -> Poses:
    """The poses of the first run of a sequential log.

    Raises:
        BenchError: a trace is missing or malformed, or its replay differs.
    """
    data, run = folder.read(log.path), log.runs[0]
    shown = {
        trace_path(log, audited): audited for audited in shown_episodes(log, data, dict(folder.files), run)
    }
    episodes = dict(_read(folder, log, data, set(shown)))
    clips: dict[tuple[int, str], Clip] = {}
    timings = {task.id: timing_of(task) for task in log.group.tasks}
    for task in log.group.tasks:
        timing = timings[task.id]
        chosen = [(audited, episodes[path]) for path, audited in shown.items() if audited.task == task.id]
        tracks = motions(task, [episode for _, episode in chosen], timing.most_steps)
        for (audited, episode), track in zip(chosen, tracks, strict=True):
            clips[audited.stage, task.id] = _clip(
                log, audited, episode, frames_of(track, timing), timing.unit
            )
    last = len(log.group.tasks)
    return Poses(
        submission=folder.name,
        group=log.group.id,
        run=run,
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


def _read(folder: Folder, log: Log, data: bytes, paths: set[str]) -> Iterator[tuple[str, RecordedEpisode]]:
    for request in trace_requests(log, data, folder.files):
        if request.path in paths:
            trace = read_trace(folder, request)
            if isinstance(trace, Problem):
                raise BenchError(trace.rule, trace.message, trace.where, trace.hint)
            yield request.path, trace


def _clip(log: Log, audited: Audited, episode: RecordedEpisode, frames: Array, unit: float) -> Clip:
    cell = (log.run == audited.run) & (log.stage == audited.stage)
    cell &= log.position == log.group.task_ids.index(audited.task)
    returns = log.return_[cell]
    if len(returns) != EVALUATION_EPISODES:
        raise BenchError("missing-cell", f"The cell has {len(returns)} episodes.", log.path)
    return Clip(
        stage=audited.stage,
        episode=audited.episode,
        steps=episode.length,
        success=episode.success,
        returns=tuple(round(value, 2) for value in returns[np.argsort(log.episode[cell])].tolist()),
        frames=len(frames),
        motion=motion_of(frames, unit),
    )
