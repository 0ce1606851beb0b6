"""Whether a recorded episode fits its task: the shapes of its actions and states, and that these restore."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import quote
from gym_extensions.rollouts.trace_reader import Array, RecordedEpisode
from gym_extensions.rollouts.traces import is_recorded

UNFIT = (KeyError, ValueError, OverflowError, BenchError)
"""What an environment raises for a state that is not its own."""


def misfits(env: Any, episodes: Sequence[RecordedEpisode]) -> Iterator[tuple[str, str]]:
    """The traces whose actions or states are of another shape than those of the environment, and how."""
    env.reset(seed=[one.seed for one in episodes[:1]])
    actions = env.single_action_space.shape
    needed = {name: rows.shape[1:] for name, rows in env.save_states().items() if is_recorded(name)}
    for one in episodes:
        shapes = {name: rows.shape[1:] for name, rows in one.states.items()}
        wrong = sorted(name for name in {*shapes, *needed} if shapes.get(name) != needed.get(name))
        if one.actions.shape[1:] != actions:
            yield one.where, f"the recorded actions do not fit the task, whose actions are {actions}."
        elif wrong and one.length > one.segment_steps:
            yield one.where, f"the recorded states do not fit the task: {quote(wrong[0])}."


def restored(env: Any, states: Sequence[dict[str, Array]]) -> list[str]:
    """Puts a state into every lane; where that fails, what is wrong with each lane's, or nothing."""
    try:
        env.restore_states({name: np.stack([one[name] for one in states]) for name in states[0]})
    except UNFIT:
        return [_alone(env, lane, one) for lane, one in enumerate(states)]
    return [""] * len(states)


def _alone(env: Any, lane: int, state: dict[str, Array]) -> str:
    try:
        env.restore_states({name: value[None] for name, value in state.items()}, indices=[lane])
    except UNFIT:
        return "the recorded states do not fit the task: they cannot be restored."
    return ""
