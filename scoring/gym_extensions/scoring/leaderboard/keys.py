"""Which boards a scorecard is on, and what a board reads of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.scorecard.model import GroupScore, Scorecard, SuiteScore


@dataclass(frozen=True, order=True)
class BoardKey:
    """Group or suite, protocol and budget of a board, and whether agents observe the task in evaluation."""

    group: str
    protocol: str
    budget: str
    task_conditioned: bool

    @property
    def groups(self) -> tuple[str, ...]:
        """The groups that the board's scores are means over."""
        return SUITES.get(self.group, (self.group,))


def lookup(card: Scorecard, key: BoardKey) -> GroupScore | SuiteScore | None:
    """The scores of an entry on a board, or None if it is not on it."""
    scores = (card.suites if key.group in SUITES else card.groups).get(key.group, {})
    score = scores.get(key.protocol)
    on_board = score is not None and score.budget == key.budget
    return score if on_board and is_task_conditioned(card) == key.task_conditioned else None


def is_task_conditioned(card: Scorecard) -> bool:
    """Whether the agent observes the task in evaluation. Such entries have separate boards."""
    return card.manifest is not None and card.manifest.observes.task_in_evaluation


def strip_for_boards(card: Scorecard) -> Scorecard:
    """The scorecard without what boards do not read, so that many fit in memory."""
    groups = {
        name: {
            protocol: GroupScore(
                published=score.published,
                budget=score.budget,
                runs=score.runs,
                tasks=(),
                metrics=score.metrics,
                reference={},
                return_matrix=(),
                episode_sketches=score.episode_sketches,
                missing_evidence=score.missing_evidence,
            )
            for protocol, score in protocols.items()
        }
        for name, protocols in card.groups.items()
    }
    return replace(card, readme="", problems=(), notes=(), groups=groups)


def board_keys(cards: Sequence[Scorecard]) -> list[BoardKey]:
    """Every board that the scorecards have an entry for, sorted, with groups before suites."""
    keys = {
        BoardKey(name, protocol, score.budget, is_task_conditioned(card))
        for card in cards
        for scores in (card.groups, card.suites)
        for name, protocols in scores.items()
        for protocol, score in protocols.items()
        if BUDGETS[score.budget].on_boards
    }
    budgets, protocols = list(BUDGETS), list(PROTOCOLS)
    return sorted(
        keys,
        key=lambda key: (
            key.group in SUITES,
            key.group,
            protocols.index(key.protocol),
            budgets.index(key.budget),
            key.task_conditioned,
        ),
    )
