"""Replays the first seconds of audited episodes and records their coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.trace_reader import Array, RecordedEpisode
from gym_extensions.scoring.replay.compatibility import misfits, restored
from gym_extensions.scoring.replay.faults import seam_fault
from gym_extensions.scoring.replay.segment import Segment, segments_of
from gym_extensions.scoring.replay.segments import MAX_ENVIRONMENTS, padded_actions, recorded_state
from gym_extensions.scoring.replay.silence import no_log_file

HINT = "Check the submission with `score --verify`."


def motions(task: Task, episodes: Sequence[RecordedEpisode], most_steps: int) -> list[Array]:
    """The coordinates of each episode, (steps + 1, n), up to a number of steps.

    The coordinates are ``qpos`` and the x and y of mocap bodies (a wall, a goal), or the position on the map
    in 2-D navigation. Every segment is replayed from its recorded state, as in verification.

    Raises:
        BenchError: a trace does not fit its task, or its replay reaches another state than the recorded.
    """
    with no_log_file():
        env = make_vec(task, 1)
        for path, sentence in misfits(env, episodes):
            raise BenchError("replay-differs", f"Not replayed: {sentence}", path, HINT)
        env.close()
        parts = [part for episode in episodes for part in segments_of(episode) if part.start < most_steps]
        rows: dict[tuple[str, int], Array] = {}
        for batch in ([part for part in parts if not part.index], [part for part in parts if part.index]):
            for start in range(0, len(batch), MAX_ENVIRONMENTS):
                chunk = batch[start : start + MAX_ENVIRONMENTS]
                rows |= _replayed(task, chunk)
    return [
        np.concatenate(
            [rows[episode.where, part.index] for part in segments_of(episode) if part.start < most_steps]
        )[: most_steps + 1]
        for episode in episodes
    ]


def _replayed(task: Task, parts: Sequence[Segment]) -> dict[tuple[str, int], Array]:
    """The coordinates after every step of each segment; in the first one, also those at the start."""
    steps = parts[0].episode.segment_steps
    env: Any = make_vec(task, len(parts))
    env.reset(seed=[part.episode.seed for part in parts])
    actions = padded_actions(parts, steps)
    if parts[0].index > 0:
        for part, sentence in zip(
            parts, restored(env, [recorded_state(part) for part in parts]), strict=True
        ):
            if sentence:
                raise BenchError("replay-differs", f"Not replayed: {sentence}", part.episode.where, HINT)
        env.step(actions[0])  # discarded, as in verification: derived quantities lag one evaluation behind
    frames = [_coordinates(env.save_states())]
    for step in range(steps):
        env.step(actions[step + 1])
        states = env.save_states()
        frames.append(_coordinates(states))
        if step == steps - 2:
            _compare(parts, states)
    env.close()
    trajectories = np.stack(frames, axis=1)
    return {
        (part.episode.where, part.index): rows[min(part.index, 1) : 1 + part.end - part.start]
        for part, rows in zip(parts, trajectories, strict=True)
    }


def _coordinates(states: dict[str, Any]) -> Array:
    if "position" in states:
        return np.array(states["position"])
    mocap = [states["mocap_pos"][:, 0, :2]] if "mocap_pos" in states else []
    return np.concatenate([states["qpos"], *mocap], axis=1)


def _compare(parts: Sequence[Segment], states: dict[str, Any]) -> None:
    """Raises BenchError if a replayed state is not the recorded one before the next segment."""
    for index, part in enumerate(parts):
        seam = {name: states[name][index] for name in part.episode.states}
        if not part.last and (fault := seam_fault(part, seam)):
            message = f"Steps {part.start} to {part.end} differ from the recorded ones: {fault}"
            raise BenchError("replay-differs", message, part.episode.where, HINT)
