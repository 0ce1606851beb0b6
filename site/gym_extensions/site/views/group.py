"""A group or suite: its tasks in order, what 1 means on each, and its boards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.metrics.paper_table import PaperRow
from gym_extensions.scoring.scorecard.model import REPORTED, ReferencesInfo
from gym_extensions.site.text.numbers import fixed
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.entrant import SEQUENTIAL, Entrant
from gym_extensions.site.views.pictures import group_picture, task_picture
from gym_extensions.site.views.reference import Measured, measured

NUMBERS = ("no run", "one run", "two runs", "three runs", "four runs", "five runs")
FIRST_ENTRIES = 2
"""How many of the best entries are compared with the paper's numbers."""


@dataclass(frozen=True)
class TaskRow:
    """A task of a group, with its picture and how its floor and ceiling were measured."""

    task: str
    picture: str
    measured: Measured | None

    @property
    def has_page(self) -> bool:
        """Whether the task is published, so that it has a page."""
        return self.task in TASKS

    @property
    def one(self) -> str:
        """What a score of 1 means, in words."""
        return "No reference has been measured" if self.measured is None else _one(self.measured)

    @property
    def zero(self) -> str:
        """What a score of 0 means, in words."""
        if self.measured is None:
            return ""
        agent = {"zero": "the zero action", "random": "random actions"}.get(self.measured.floor_agent)
        return f"0 = {agent or self.measured.floor_agent}: return {_number(self.measured.floor)}"


@dataclass(frozen=True)
class PaperTable:
    """The four columns of the paper for some entries, per task.

    Args:
        entries: name and title of each, the publication first.
        rows: per task id, the cells of each entry; None where it lacks the task.
    """

    entries: tuple[tuple[str, str], ...]
    rows: tuple[tuple[str, tuple[PaperRow | None, ...]], ...]


@dataclass(frozen=True)
class Group:
    """A group or suite.

    Args:
        id: group id or suite name.
        tasks: in training order; empty for a suite.
        members: the group ids of a suite; empty for a group.
        boards: its boards, in the order of the overview.
        paper: the paper's columns; None without a publication.
    """

    id: str
    tasks: tuple[TaskRow, ...]
    members: tuple[str, ...]
    boards: tuple[Board, ...]
    paper: PaperTable | None

    @property
    def picture(self) -> str:
        """The path of its picture; empty without one."""
        return group_picture(self.id)

    @property
    def task_ids(self) -> tuple[str, ...]:
        """Its tasks in training order."""
        return tuple(row.task for row in self.tasks)

    @property
    def summaries(self) -> tuple[str, ...]:
        """What its bodies are and do, one sentence per base body."""
        bodies = [TASKS[row.task].body.prose.summary for row in self.tasks if row.has_page]
        return tuple(dict.fromkeys(bodies))

    @property
    def entries(self) -> int:
        """The number of different entries on its boards."""
        return len({row.entry.name for board in self.boards for row in board.rows})


def groups(
    boards: Sequence[Board], entrants: Sequence[Entrant], references: ReferencesInfo
) -> tuple[Group, ...]:
    """Every published suite and group in the order of the catalog, and others that have a board."""
    by_group: dict[str, list[Board]] = {}
    for board in boards:
        by_group.setdefault(board.group, []).append(board)
    published = {group.id: group for group in GROUPS.values()}
    ids = dict.fromkeys((*SUITES, *published, *by_group))
    known = measured(references)
    return tuple(_group(name, published.get(name), by_group.get(name, []), entrants, known) for name in ids)


def _group(
    name: str,
    group: TaskGroup | None,
    boards: Sequence[Board],
    entrants: Sequence[Entrant],
    known: Mapping[str, Measured],
) -> Group:
    tasks = group.task_ids if group else next((board.trials[0].tasks for board in boards), ())
    return Group(
        id=name,
        tasks=tuple(TaskRow(task, task_picture(task), known.get(task)) for task in tasks),
        members=SUITES.get(name, ()),
        boards=tuple(boards),
        paper=_paper(name, tasks, boards, entrants),
    )


def _paper(
    name: str, tasks: Sequence[str], boards: Sequence[Board], entrants: Sequence[Entrant]
) -> PaperTable | None:
    """Publications of the group, and the best entries of its first board of sequential training."""
    reported = [
        entrant.card
        for entrant in entrants
        if entrant.card.trust == REPORTED and SEQUENTIAL in entrant.card.groups.get(name, {})
    ]
    if not reported:
        return None
    sequential = next((board for board in boards if board.protocol == SEQUENTIAL), None)
    best = [row.card for row in sequential.rows[:FIRST_ENTRIES]] if sequential else []
    cards = [*reported, *(card for card in best if card not in reported)]
    tables = [{row.task: row for row in card.groups[name][SEQUENTIAL].paper_table} for card in cards]
    rows = tuple((task, tuple(table.get(task) for table in tables)) for task in tasks)
    return PaperTable(tuple((card.name, card.title) for card in cards), rows)


def _one(reference: Measured) -> str:
    steps = f", {reference.budget} steps" if reference.budget else ""
    number = len(reference.runs)
    runs = NUMBERS[number] if number < len(NUMBERS) else f"{number} runs"
    returns = f": returns {', '.join(map(_number, reference.runs))}" if reference.runs else ""
    if reference.ceiling is None:
        if not reference.agent:
            return "No 1 on the scale yet: no reference agent was trained on it"
        return f"No 1 on the scale: {reference.agent}{steps}, {runs}, did not learn the task{returns}"
    if not reference.budget:
        return f"1 = {reference.agent or 'no agent'}: return {_number(reference.ceiling)}"
    mean = "" if number < 2 else f"; mean {_number(reference.ceiling)}"
    return f"1 = {reference.agent}{steps}{f', {runs}' if number else ''}{returns}{mean}"


def _number(value: float) -> str:
    return fixed(value, 0 if abs(value) >= 10 else 2)
