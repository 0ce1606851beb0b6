"""Replays the recorded segments of a task, side by side in a batch of environments."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.success import IS_SUCCESS
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.trace_reader import Array, RecordedEpisode
from gym_extensions.scoring.replay.compatibility import misfits, restored
from gym_extensions.scoring.replay.faults import ACTIONS_DIFFER, HINTS, REPLAY_DIFFERS, Fault
from gym_extensions.scoring.replay.policy_actions import action_fault

SUCCESSES = {1: True, 0: False, -1: None}
MAX_ENVIRONMENTS = 256
"""Segments that are replayed side by side."""


@dataclass(frozen=True)
class Segment:
    """The ``index``-th segment of an episode, from step ``start`` to ``end`` (exclusive)."""

    episode: RecordedEpisode
    index: int
    start: int
    end: int

    @property
    def last(self) -> bool:
        """Whether the episode ends with it."""
        return self.end == self.episode.length


def segments_of(episode: RecordedEpisode) -> list[Segment]:
    """The segments of an episode, in order."""
    starts = range(0, episode.length, episode.segment_steps)
    ends = [*starts[1:], episode.length]
    return [
        Segment(episode, index, start, end)
        for index, (start, end) in enumerate(zip(starts, ends, strict=True))
    ]


@contextmanager
def quiet() -> Iterator[None]:
    """Stops MuJoCo from writing warnings (recorded states may be unstable) into the current folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def usable_cpus() -> int:
    """The CPUs that this process may use, or all of the machine where the system does not say."""
    count: Callable[[], int | None] = getattr(os, "process_cpu_count", os.cpu_count)  # new in Python 3.13
    return count() or 1


def replay(task: Task, episodes: Sequence[RecordedEpisode]) -> list[Problem]:
    """The first difference of each episode between its trace and its replay or policy, as a problem."""
    with quiet():
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
        if fault := _fault(part, math.fsum(rewards[:count, index]), ended.tolist(), success, state):
            yield Fault(REPLAY_DIFFERS, part.start, fault)
            continue
        seen = [rows[index] for rows in observations[:count]]
        step, fault = action_fault(part.episode, part.start, seen, env.single_action_space)
        yield Fault(ACTIONS_DIFFER, step, fault) if fault else None


def describe_success(success: bool | None) -> str:
    """The end of an episode in words."""
    return {True: "with success", False: "without success", None: "without a definition of success"}[success]


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


def _fault(
    part: Segment, total: float, ended: list[int], success: bool | None, seam: dict[str, Array]
) -> str:
    """A sentence on what differs in one segment, or an empty string.

    Args:
        part: the segment.
        total: sum of the replayed rewards.
        ended: steps of the segment, from 0, at which the replayed episode terminated.
        success: ``is_success`` of the last replayed step; None where the task defines no success.
        seam: the replayed state before the next segment.
    """
    tolerance = part.episode.task.body.segments.tolerance
    expected = [part.end - part.start - 1] if part.last and part.episode.terminated else []
    if ended != expected:
        replayed = f"after step {part.start + ended[0] + 1}" if ended else "not in this segment"
        claimed = f"after step {part.end}" if expected else "not in this segment"
        return f"the episode terminates {replayed}, the log says {claimed}."
    claimed_return = float(part.episode.returns[part.index])
    if not abs(total - claimed_return) <= tolerance * max(1.0, abs(claimed_return)):
        return f"the rewards sum to {total!r}, the trace says {claimed_return!r}."
    if part.last:
        if success != part.episode.success:
            replayed, claimed = describe_success(success), describe_success(part.episode.success)
            return f"the episode ends {replayed}, the log says {claimed}."
        return ""
    for name, states in sorted(part.episode.states.items()):
        claimed_state = states[part.index]
        apart = np.abs(seam[name] - claimed_state) / np.maximum(1.0, np.abs(claimed_state))
        if not (apart <= tolerance).all():
            return f"the state's {name!r} before the next segment differs by {float(np.max(apart)):.3g}."
    return ""
