"""Replays the recorded segments of a task, side by side in a batch of environments."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.success import IS_SUCCESS
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.trace_reader import Array, RecordedEpisode
from gym_extensions.scoring.replay.compatibility import misfits, restored
from gym_extensions.scoring.replay.faults import ACTIONS_DIFFER, HINTS, REPLAY_DIFFERS, Fault, segment_fault
from gym_extensions.scoring.replay.policy_actions import action_fault
from gym_extensions.scoring.replay.segment import Segment, segments_of
from gym_extensions.scoring.replay.silence import no_log_file

SUCCESSES = {1: True, 0: False, -1: None}
MAX_ENVIRONMENTS = 256
"""Segments that are replayed side by side."""


def usable_cpus() -> int:
    """The CPUs that this process may use, or all of the machine where the system does not say."""
    count: Callable[[], int | None] = getattr(os, "process_cpu_count", os.cpu_count)  # new in Python 3.13
    return count() or 1


def replay(task: Task, episodes: Sequence[RecordedEpisode]) -> list[Problem]:
    """The first difference of each episode between its trace and its replay or policy, as a problem."""
    with no_log_file():
        model = make_vec(task, 1)
        faults = {path: Fault(REPLAY_DIFFERS, 0, fault) for path, fault in misfits(model, episodes)}
        model.close()
        parts = [part for episode in episodes if episode.where not in faults for part in segments_of(episode)]
        first = [part for part in parts if part.index == 0]
        later = [part for part in parts if part.index > 0]
        for batch in filter(None, (first, later)):
            for part, fault in _replay_batch(task, batch):
                path = part.episode.where
                if path not in faults or fault.step < faults[path].step:
                    faults[path] = fault
    return [
        Problem(fault.rule, path, f"Steps {fault.step} and following: {fault.message}", HINTS[fault.rule])
        for path, fault in sorted(faults.items())
    ]


def _replay_batch(task: Task, batch: Sequence[Segment]) -> Iterator[tuple[Segment, Fault]]:
    """The segments of a batch that differ, each with its fault."""
    count = min(MAX_ENVIRONMENTS, len(batch))
    env = make_vec(task, count, num_threads=usable_cpus())
    for start in range(0, len(batch), count):
        chunk = batch[start : start + count]
        padded = [*chunk, *[chunk[-1]] * (count - len(chunk))]
        faults = zip(chunk, _faults(env, padded), strict=False)
        yield from ((part, fault) for part, fault in faults if fault)
    env.close()


def _faults(env: Any, parts: Sequence[Segment]) -> Iterator[Fault | None]:
    """For each segment what differs, or None."""
    steps = parts[0].episode.segment_steps
    actions = padded_actions(parts, steps)
    observation, _ = env.reset(seed=[part.episode.seed for part in parts])
    if parts[0].index > 0:
        faults = restored(env, [recorded_state(part) for part in parts])
        if any(faults):
            yield from (
                Fault(REPLAY_DIFFERS, part.start, fault) if fault else None
                for part, fault in zip(parts, faults, strict=True)
            )
            return
        observation = env.step(actions[0])[
            0
        ]  # derived quantities lag one evaluation behind: this step is discarded
    rewards = np.zeros((steps, len(parts)))
    ends = np.zeros((steps, len(parts)), np.bool_)
    successes = np.full((steps, len(parts)), -1, np.int8)
    seam: dict[str, Array] = {}
    observations, has_policies = list[Array](), any(part.episode.policy for part in parts)
    for step in range(steps):
        if has_policies:
            observations.append(np.array(observation))
        observation, rewards[step], ends[step], _, infos = env.step(actions[step + 1])
        if IS_SUCCESS in infos:
            successes[step] = np.where(infos[f"_{IS_SUCCESS}"], infos[IS_SUCCESS], -1)
        if step == steps - 2:
            seam = env.save_states()
    for index, part in enumerate(parts):
        count = part.end - part.start
        ended = np.flatnonzero(ends[:count, index])
        state = {name: values[index] for name, values in seam.items()}
        success = SUCCESSES[int(successes[count - 1, index])]
        if fault := segment_fault(part, math.fsum(rewards[:count, index]), ended.tolist(), success, state):
            yield Fault(REPLAY_DIFFERS, part.start, fault)
            continue
        seen = [rows[index] for rows in observations[:count]]
        step, fault = action_fault(part.episode, part.start, seen, env.single_action_space)
        yield Fault(ACTIONS_DIFFER, step, fault) if fault else None


def recorded_state(part: Segment) -> dict[str, Array]:
    """The recorded state one step before the segment."""
    return {name: states[part.index - 1] for name, states in part.episode.states.items()}


def padded_actions(parts: Sequence[Segment], steps: int) -> NDArray[np.float32]:
    """Actions (steps + 1, segments, …) of each segment and the step before it, padded with zeros."""
    recorded = parts[0].episode.actions
    actions = np.zeros((steps + 1, len(parts), *recorded.shape[1:]), recorded.dtype)
    for index, part in enumerate(parts):
        first = max(part.start - 1, 0)
        row = first - part.start + 1
        actions[row : row + part.end - first, index] = part.episode.actions[first : part.end]
    return actions
