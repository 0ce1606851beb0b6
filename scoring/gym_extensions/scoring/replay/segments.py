"""The recorded segments of a task, stepped as lanes of one batch in our own environments."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.trace_reader import Array, RecordedEpisode
from gym_extensions.scoring.replay.compatibility import misfits, restored

LANES = 256
HINT = "Record it with the pinned versions; if it was, tell the maintainers the platform that it was made on."


@dataclass(frozen=True)
class Segment:
    """The ``index``-th segment of an episode: steps ``start`` to ``end`` (exclusive)."""

    episode: RecordedEpisode
    index: int
    start: int
    end: int

    @property
    def last(self) -> bool:
        """Whether the episode ends with it."""
        return self.end == self.episode.length


def segments_of(episode: RecordedEpisode) -> list[Segment]:
    """The episode, cut."""
    starts = range(0, episode.length, episode.segment_steps)
    ends = [*starts[1:], episode.length]
    return [Segment(episode, *place) for place in zip(range(len(starts)), starts, ends, strict=True)]


@contextmanager
def _no_log_file() -> Iterator[None]:
    """Keeps MuJoCo from writing its warnings (a stranger's states are unstable) into the current folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


def replay(task: Task, episodes: Sequence[RecordedEpisode]) -> list[Problem]:
    """At most one problem an episode: the first segment that does not come out as claimed."""
    with _no_log_file():
        model = make_vec(task, 1)
        unfit = dict(misfits(model, episodes))
        model.close()
        parts = [part for one in episodes if one.where not in unfit for part in segments_of(one)]
        first = [part for part in parts if part.index == 0]
        later = [part for part in parts if part.index > 0]
        faults: dict[str, tuple[int, str]] = {where: (0, fault) for where, fault in unfit.items()}
        for batch in filter(None, (first, later)):
            lanes = min(LANES, len(batch))
            env = make_vec(task, lanes, num_threads=_processors())
            for at in range(0, len(batch), lanes):
                chunk = batch[at : at + lanes]
                padded = chunk + [chunk[-1]] * (lanes - len(chunk))
                for part, fault in zip(chunk, _faults(env, padded), strict=False):
                    where = part.episode.where
                    if fault and (where not in faults or part.start < faults[where][0]):
                        faults[where] = (part.start, fault)
            env.close()
    return [
        Problem("replay-differs", where, f"Steps {start} and following: {fault}", HINT)
        for where, (start, fault) in sorted(faults.items())
    ]


def _faults(env: Any, lanes: Sequence[Segment]) -> Iterator[str]:
    """For every lane what does not come out as claimed, as a sentence, or nothing."""
    steps = lanes[0].episode.segment_steps
    actions = _actions(lanes, steps)
    env.reset(seed=[part.episode.seed for part in lanes])
    if lanes[0].index > 0:
        faults = restored(env, [_state(part) for part in lanes])
        if any(faults):
            yield from faults
            return
        env.step(actions[0])  # derived quantities lag one evaluation behind: this step is discarded
    rewards = np.zeros((steps, len(lanes)))
    ends = np.zeros((steps, len(lanes)), np.bool_)
    seam: dict[str, Array] = {}
    for step in range(steps):
        _, rewards[step], ends[step], _, _ = env.step(actions[step + 1])
        if step == steps - 2:
            seam = env.save_states()
    for lane, part in enumerate(lanes):
        count = part.end - part.start
        ended = np.flatnonzero(ends[:count, lane])
        state = {name: values[lane] for name, values in seam.items()}
        yield _fault(part, math.fsum(rewards[:count, lane]), ended.tolist(), state)


def _state(part: Segment) -> dict[str, Array]:
    """The recorded state one step before the segment."""
    return {name: rows_of_name[part.index - 1] for name, rows_of_name in part.episode.states.items()}


def _actions(lanes: Sequence[Segment], steps: int) -> NDArray[np.float32]:
    """Actions (steps + 1, lanes, …): of the step before each segment, of its steps, zeros after its end."""
    played = lanes[0].episode.actions
    found = np.zeros((steps + 1, len(lanes), *played.shape[1:]), played.dtype)
    for lane, part in enumerate(lanes):
        first = max(part.start - 1, 0)
        row = first - part.start + 1
        found[row : row + part.end - first, lane] = part.episode.actions[first : part.end]
    return found


def _fault(part: Segment, found: float, ended: list[int], seam: dict[str, Array]) -> str:
    """What does not come out as claimed in one segment, as a sentence, or nothing."""
    tolerance = part.episode.task.body.segments.tolerance
    expected = [part.end - part.start - 1] if part.last and part.episode.terminated else []
    if ended != expected:
        told = f"after step {part.start + ended[0] + 1}" if ended else "not in this segment"
        claimed = f"after step {part.end}" if expected else "not in this segment"
        return f"the episode terminates {told}, the log says {claimed}."
    claimed_return = float(part.episode.returns[part.index])
    if not abs(found - claimed_return) <= tolerance * max(1.0, abs(claimed_return)):
        return f"the rewards sum to {found!r}, the trace says {claimed_return!r}."
    if part.last:
        return ""
    for name, rows_of_name in sorted(part.episode.states.items()):
        claimed_state = rows_of_name[part.index]
        apart = np.abs(seam[name] - claimed_state) / np.maximum(1.0, np.abs(claimed_state))
        if not (apart <= tolerance).all():
            return f"the state's {name!r} before the next segment differs by {float(np.max(apart)):.3g}."
    return ""
