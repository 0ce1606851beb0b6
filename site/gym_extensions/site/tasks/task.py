"""One task: its sheet, its base body, the groups that it belongs to, its references and its best entries."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from markupsafe import Markup, escape

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.registry import TASKS, VERSIONS, task
from gym_extensions.catalog.sheets import Sheet, sheet
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.scoring.metrics.paper_table import PaperRow
from gym_extensions.site.text.labels import VERIFIED, level
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.board_row import Row
from gym_extensions.site.views.entrant import SEQUENTIAL
from gym_extensions.site.views.pictures import task_picture
from gym_extensions.site.views.reference import Measured

BEST = 5
"""Entries that the page of a task lists."""


@dataclass(frozen=True)
class BestEntry:
    """An entry on a board, with the mean returns of one task."""

    board: Board
    row: Row
    returns: PaperRow

    @property
    def end(self) -> float:
        """The mean return at the end."""
        return self.returns.fully_trained.mean if self.returns.fully_trained else float("-inf")


@dataclass(frozen=True)
class TaskView:
    """A task as its page shows it."""

    task: Task
    measured: Measured | None
    best: tuple[BestEntry, ...]

    @property
    def id(self) -> str:
        """The task's id."""
        return self.task.id

    @property
    def inputs(self) -> bytes:
        """What its page depends on besides the code and the references."""
        best = [(row.board.id, row.row.card.name, row.row.card.title, row.returns) for row in self.best]
        return repr((self.task, self.measured, best)).encode()

    @cached_property
    def sheet(self) -> Sheet | None:
        """What follows from its model."""
        return sheet(self.task.id)

    @property
    def base(self) -> Task | None:
        """The task of the base body without variations; None for that task itself and for maps."""
        if not self.task.variations or self.task.body.family == "navigation":
            return None
        return task(self.task.base)

    @property
    def picture(self) -> str:
        """The path of its picture; empty without one."""
        return task_picture(self.task.id)

    @property
    def base_picture(self) -> str:
        """The path of the base body's picture; empty if it is the same."""
        picture = task_picture(self.base.id) if self.base else ""
        return "" if picture == self.picture else picture

    @property
    def gravity(self) -> float | None:
        """Its gravity relative to that of the base body; None if gravity does not differ."""
        factors = [variation.factor for variation in self.task.variations if isinstance(variation, Gravity)]
        return factors[0] if factors else None

    @property
    def fingerprint(self) -> str:
        """Its published fingerprint."""
        return published(self.task.id)

    @property
    def versions(self) -> tuple[tuple[int, str], ...]:
        """Each version and what changed with it."""
        return tuple((number, VERSIONS[number]) for number in range(self.task.version + 1))

    @property
    def facts(self) -> tuple[tuple[str, Markup], ...]:
        """Reward, start, end, time limit, success and source, in words."""
        prose, success = self.task.body.prose, self.task.body.success
        facts = (
            ("Reward per step", prose.reward),
            ("Start", prose.start),
            ("End", prose.end),
            ("Time limit", f"{self.task.max_steps} steps."),
            ("Success", success.text if success else "Not defined."),
            ("Source", prose.source),
        )
        return tuple((name, _with_code(text)) for name, text in facts)

    @property
    def groups(self) -> tuple[tuple[str, int, int], ...]:
        """Id of each group that it belongs to, its position there, and the number of tasks."""
        return tuple(
            (group.id, group.task_ids.index(self.task.id) + 1, len(group.tasks))
            for group in GROUPS.values()
            if self.task.id in group.task_ids
        )


def _with_code(text: str) -> Markup:
    """A text of the catalog, with what is between backticks as code."""
    return Markup(re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape(text))))


def best_entries(boards: Sequence[Board]) -> dict[str, tuple[BestEntry, ...]]:
    """The replayed entries with the highest return at the end of sequential training, by task id."""
    by_task: dict[str, list[BestEntry]] = {}
    for board in boards:
        if board.protocol != SEQUENTIAL or board.suite:
            continue
        for row in board.rows:
            detail = row.trial.detail
            if detail is None or row.duplicate_of or level(row.card) not in VERIFIED:
                continue
            for returns in detail.paper_table:
                if returns.fully_trained:
                    by_task.setdefault(returns.task, []).append(BestEntry(board, row, returns))
    return {
        name: tuple(sorted(rows, key=lambda best: (-best.end, best.row.card.name))[:BEST])
        for name, rows in by_task.items()
    }


def by_base() -> dict[str, tuple[Task, ...]]:
    """Every published task by the name of its base body, in the order of the catalog."""
    bases: dict[str, list[Task]] = {}
    for row in TASKS.values():
        bases.setdefault(row.base, []).append(row)
    return {base: tuple(rows) for base, rows in bases.items()}
