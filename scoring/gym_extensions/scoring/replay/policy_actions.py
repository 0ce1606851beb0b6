"""Compares the recorded actions of a segment with the policy that the submission contains for its stage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies.agreement import TOLERANCE, differences
from gym_extensions.rollouts.trace_reader import Array, RecordedEpisode


def action_fault(
    episode: RecordedEpisode, start: int, observations: Sequence[Array], space: Any
) -> tuple[int, str]:
    """The first step at which an action is not the policy's, with a sentence; 0 and "" if there is none.

    Args:
        episode: the episode with its policy; without one, there is nothing to compare.
        start: the step of the first observation.
        observations: n observations, as replayed.
        space: the action space.
    """
    if episode.policy is None:
        return 0, ""
    actions = episode.actions[start : start + len(observations)]
    try:
        apart = differences(
            episode.policy, np.stack(observations), actions, (space.low, space.high), episode.task_index
        )
    except BenchError as misfit:
        return start, misfit.message
    wrong = (~(apart <= TOLERANCE)).nonzero()[0]
    if not len(wrong):
        return 0, ""
    first = int(wrong[0])
    difference = f"{float(apart[first]):.3g} half widths of the action space"
    return start + first, f"the recorded action differs from the policy's by {difference}."
