"""Checks whether a recorded episode fits its task. Shapes must agree and states must be restorable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import quote
from gym_extensions.rollouts.trace_reader import Array, RecordedEpisode
from gym_extensions.rollouts.traces import is_recorded

MISFIT_ERRORS = (KeyError, ValueError, OverflowError, BenchError)
"""What an environment raises for a state of another task."""


def misfits(env: Any, episodes: Sequence[RecordedEpisode]) -> Iterator[tuple[str, str]]:
    """Path and sentence for each trace whose actions or states have other shapes than the environment's."""
    env.reset(seed=[episode.seed for episode in episodes[:1]])
    space = env.single_action_space
    expected = {name: rows.shape[1:] for name, rows in env.save_states().items() if is_recorded(name)}
    for episode in episodes:
        shapes = {name: rows.shape[1:] for name, rows in episode.states.items()}
        wrong = sorted(name for name in {*shapes, *expected} if shapes.get(name) != expected.get(name))
        if episode.actions.shape[1:] != space.shape:
            yield episode.where, f"the recorded actions do not fit the task, whose actions are {space.shape}."
        elif ((episode.actions < space.low) | (episode.actions > space.high)).any():
            yield episode.where, "a recorded action is outside the action space."
        elif wrong and episode.length > episode.segment_steps:
            yield episode.where, f"the recorded states do not fit the task: {quote(wrong[0])}."


def restored(env: Any, states: Sequence[dict[str, Array]]) -> list[str]:
    """Restores one state per environment of the batch.

    Returns:
        For each environment a sentence on what is wrong with its state, or an empty string. If any state is
        wrong, none counts as restored.
    """
    try:
        env.restore_states({name: np.stack([state[name] for state in states]) for name in states[0]})
    except MISFIT_ERRORS:
        return [_restored_alone(env, index, state) for index, state in enumerate(states)]
    return [""] * len(states)


def _restored_alone(env: Any, index: int, state: dict[str, Array]) -> str:
    try:
        env.restore_states({name: value[None] for name, value in state.items()}, indices=[index])
    except MISFIT_ERRORS:
        return "the recorded states do not fit the task: they cannot be restored."
    return ""
