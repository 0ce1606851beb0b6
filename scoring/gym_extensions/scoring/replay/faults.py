"""The problems that replay reports: their rules, and what to do about each."""

from __future__ import annotations

from typing import NamedTuple

REPLAY_DIFFERS, ACTIONS_DIFFER = "replay-differs", "actions-differ"
HINTS = {
    REPLAY_DIFFERS: (
        "Record it with the pinned versions; "
        "if it was, tell the maintainers the platform that it was made on."
    ),
    ACTIONS_DIFFER: "Store the policy that recorded the actions, after the stage that its name states.",
}
"""By rule."""


class Fault(NamedTuple):
    """What differs in a segment, and the step from which it does."""

    rule: str
    step: int
    message: str
