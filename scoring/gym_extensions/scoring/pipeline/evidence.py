"""What is checked of a submission beyond the rules: traces, policies and archive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.scoring.scorecard.model import Scorecard


@dataclass(frozen=True)
class Evidence:
    """What is checked beyond the rules. All of it loads the simulator.

    Args:
        replays: whether to replay the recorded episodes, which the salt must have drawn if there is one.
        salt: a value that was fixed after the submission; None accepts the salt of the traces.
        reevaluates: whether to evaluate the policies on new seeds, which follow from the salt. The episodes
            are replayed too, whatever salt drew them.
        archive: a zip file with the traces of all episodes.
    """

    replays: bool = False
    salt: str | None = None
    reevaluates: bool = False
    archive: Path | None = None

    @property
    def is_needed(self) -> bool:
        """Whether there is anything to check."""
        return self.replays or self.reevaluates or self.archive is not None


def with_evidence(
    card: Scorecard, path: Path, checks: Evidence, groups: Mapping[str, TaskGroup]
) -> Scorecard:
    """The scorecard with the trust that the checks give, or with the problems that they find."""
    from gym_extensions.scoring.replay.archive import with_archive
    from gym_extensions.scoring.replay.verify import verified

    if checks.archive is not None:
        card = with_archive(card, path, checks.archive, groups)
    if checks.replays or checks.reevaluates:
        card = verified(card, path, groups, checks.salt if checks.replays else None)
    if checks.reevaluates:
        from gym_extensions.scoring.reevaluation.scorecard import reevaluated

        card = reevaluated(card, path, checks.salt or "", groups)
    return card
