"""The problems that replay reports: their rules, and what to do about each."""

from __future__ import annotations

from typing import NamedTuple

REPLAY_DIFFERS, ACTIONS_DIFFER = "replay-differs", "actions-differ"
PLATFORM = "if it was, tell the maintainers the platform that it was made on."
HINTS = {
    REPLAY_DIFFERS: f"Record it with the pinned versions; {PLATFORM}",
    ACTIONS_DIFFER: f"Store the policy of the stage that its name states; {PLATFORM}",
}
"""By rule."""


class Fault(NamedTuple):
    """What differs in a segment, and the step from which it does."""

    rule: str
    step: int
    message: str
