"""The document that all pages are made from: scorecards, their boards, and the paths of their pages."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, field
from functools import cached_property

from gym_extensions.errors import BenchError
from gym_extensions.scoring.leaderboard.board import boards as scored_boards
from gym_extensions.scoring.leaderboard.model import BoardsDocument
from gym_extensions.scoring.poses.files import PosesByGroup
from gym_extensions.scoring.scorecard.model import ReferencesInfo, Scorecard, ScorecardDocument
from gym_extensions.site.views.board import Board, boards


@dataclass(frozen=True)
class Leaderboard:
    """The scorecards and their boards, and the poses of entries."""

    document: ScorecardDocument
    poses: PosesByGroup = field(default_factory=dict)

    @cached_property
    def entries(self) -> tuple[Scorecard, ...]:
        """Every submission, sorted by name."""
        return tuple(sorted(self.document.submissions, key=lambda card: card.name))

    @cached_property
    def references(self) -> ReferencesInfo:
        """The references that normalize all scores."""
        return self.document.references

    @cached_property
    def boards(self) -> tuple[Board, ...]:
        """Every board, in the order of the index."""
        return boards(self.scored.boards, self.entries)

    @cached_property
    def scored(self) -> BoardsDocument:
        """The scorer's boards of all submissions without problems."""
        return scored_boards([card for card in self.document.submissions if not card.problems])

    def has_poses(self, name: str) -> bool:
        """Whether there are poses of the entry with this name."""
        return any(entry == name for entry, _ in self.poses)

    @cached_property
    def addresses(self) -> dict[str, str]:
        """The path of every submission's page, by the submission's name."""
        return addresses([entry.name for entry in self.entries])


def addresses(names: list[str]) -> dict[str, str]:
    """A path per name, safe in file systems and URLs, and unique even where case is ignored.

    Raises:
        BenchError: two submissions have the same name.
    """
    for name in names:
        if names.count(name) > 1:
            hint = "Rename one of the folders."
            raise BenchError("same-name", f"Two submissions have the name {name!r}.", hint=hint)
    paths: dict[str, str] = {}
    slugs: set[str] = set()
    for name in sorted(names):
        slug = re.sub(r"[^a-z0-9-]+", "-", name.lower()).strip("-")[:80]
        if slug != name or slug in slugs:
            slug = f"{slug}-{hashlib.sha256(name.encode()).hexdigest()[:8]}".lstrip("-")
        slugs.add(slug)
        paths[name] = f"submissions/{slug}.html"
    return paths
