"""The problems that replay reports: what differs in a segment, by which rule, and what to do about it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gym_extensions.rollouts.trace_reader import Array
from gym_extensions.scoring.replay.segment import Segment

REPLAY_DIFFERS, ACTIONS_DIFFER = "replay-differs", "actions-differ"
PLATFORM = "if it was, tell the maintainers the platform that it was made on."
HINTS = {
    REPLAY_DIFFERS: f"Record it with the pinned versions; {PLATFORM}",
    ACTIONS_DIFFER: f"Store the policy of the stage that its name states; {PLATFORM}",
}
"""By rule."""
EXACT_STATES = ("steps", "struck", "time")
"""States that count or switch: they are the same on every machine, so a seam may not change them at all."""


class Fault(NamedTuple):
    """What differs in a segment, and the step from which it does."""

    rule: str
    step: int
    message: str


def describe_success(success: bool | None) -> str:
    """The end of an episode in words."""
    return {True: "with success", False: "without success", None: "without a definition of success"}[success]


def segment_fault(
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
    return seam_fault(part, seam)


def seam_fault(part: Segment, seam: dict[str, Array]) -> str:
    """A sentence on what differs in the state before the next segment, or an empty string."""
    for name, states in sorted(part.episode.states.items()):
        claimed = states[part.index]
        apart = np.abs(seam[name] - claimed) / np.maximum(1.0, np.abs(claimed))
        tolerance = 0.0 if name in EXACT_STATES else part.episode.task.body.segments.tolerance
        if not (apart <= tolerance).all():
            return f"the state's {name!r} before the next segment differs by {float(np.max(apart)):.3g}."
    return ""
