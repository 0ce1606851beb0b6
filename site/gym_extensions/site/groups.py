"""Groups and suites with their tasks and boards, and the overview of all boards."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gym_extensions.catalog.groups import GROUPS, SUITES, TaskGroup
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.rollouts.review import REPORTED
from gym_extensions.scoring.published import PaperRow
from gym_extensions.scoring.scorecard import ReferencesInfo
from gym_extensions.site.boards import Board, Entrant, Row
from gym_extensions.site.tasks import Measured, group_picture, measured, task_picture
from gym_extensions.site.text import count, ends, fixed, mean, short
from gym_extensions.site.trial import SEQUENTIAL

FIRST_ENTRIES = 2
"""How many of the best entries are compared with the paper's numbers."""


@dataclass(frozen=True)
class TaskRow:
    """A task of a group, with its picture and how its floor and expert were measured."""

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
        if entrant.card.level == REPORTED and SEQUENTIAL in entrant.card.groups.get(name, {})
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
    if reference.expert is not None:
        provisional = f" (provisional: {reference.provisional})" if reference.provisional else ""
        return f"1 = {reference.agent or 'expert'}: return {_number(reference.expert)}{provisional}"
    tried = "" if reference.attempt is None else f"; the best attempt returns {_number(reference.attempt)}"
    return f"Open: no expert is known that is clearly better than 0{tried}"


def _number(value: float) -> str:
    return fixed(value, 0 if abs(value) >= 10 else 2)


MAX_ROWS = 24
"""Boards in the table; further ones are on the pages of the groups."""
MAX_REASONS = 6
MAX_TITLE = 40
MAX_NAMED = 3
"""Boards whose first entry a sentence names."""


@dataclass(frozen=True)
class Overview:
    """The boards of sequential training.

    Args:
        rows: boards with a score.
        without_score: boards whose entries have no score.
        more: the number of boards with a score that have no row.
    """

    rows: tuple[Board, ...]
    without_score: tuple[Board, ...]
    more: int

    @property
    def answers(self) -> tuple[str, ...]:
        """Who is best in final performance and who forgets least, in sentences; empty without ranks.

        Where some boards have several ranked entries, the boards of a single one are left out.
        """
        groups = [board for board in self.rows if not board.suite] or list(self.rows)
        compared = [board for board in groups if board.ranked > 1] or groups
        final = [(board, row) for board in compared if (row := board.best)]
        least = [(board, row) for board in compared if (row := board.least_forgetting)]
        return tuple(
            sentence
            for sentence in (
                _answer("Best final performance", final, "final_performance", "leads on"),
                _answer("Least forgetting among those that learned", least, "forgetting", "forgets least on"),
            )
            if sentence
        )


def overview(boards: Sequence[Board]) -> Overview:
    """The overview of all boards, those with a ranked entry first, in the order of ``boards``."""
    sequential = [board for board in boards if board.protocol == SEQUENTIAL]
    scored = sorted((board for board in sequential if board.leader), key=lambda board: board.best is None)
    return Overview(
        rows=tuple(scored[:MAX_ROWS]),
        without_score=tuple(board for board in sequential if not board.leader),
        more=max(len(scored) - MAX_ROWS, 0),
    )


def reasons(boards: Sequence[Board]) -> tuple[tuple[str, tuple[Board, ...]], ...]:
    """Boards without a score by the reason, the first reasons; a suite lacks a group's score."""
    by_reason: dict[str, list[Board]] = {}
    for board in boards:
        why = "A suite needs a score in every group." if board.suite else board.why_no_score
        by_reason.setdefault(why, []).append(board)
    return tuple((why, tuple(members)) for why, members in by_reason.items())[:MAX_REASONS]


def _answer(what: str, rows: Sequence[tuple[Board, Row]], metric: str, verb: str) -> str:
    """Who is first on most boards, or who is first on each of the first boards."""
    if not rows:
        return ""
    ((name, wins),) = Counter(row.entry.name for _, row in rows).most_common(1)
    if len(rows) > MAX_NAMED and 2 * wins > len(rows):
        won = [row for _, row in rows if row.entry.name == name]
        ties = sum(row.tied(metric) > 0 for row in won)
        among = f", {ties} of them in a tie" if ties else ""
        boards = count(len(rows), "board")
        ranked = "several ranked entries" if rows[0][0].ranked > 1 else "a ranked entry"
        return f"{what}: {_entry(won[0])} {verb} {wins} of {boards} with {ranked}{among}."
    named = [_first(board, row, metric) for board, row in rows[:MAX_NAMED]]
    if len(rows) > MAX_NAMED:
        named.append(f"{count(len(rows) - MAX_NAMED, 'more board')} below")
    return f"{what}: {'; '.join(named)}."


def _first(board: Board, row: Row, metric: str) -> str:
    """The first entry of a board, its value, and how many entries are tied with it."""
    value = row.trial.metric(metric)
    label = ", task label" if board.task_conditioned else ""
    text = f"{_entry(row)} with {mean(value)} ({ends(value)}) on {_board_group(board)}, {board.budget}{label}"
    tied = row.tied(metric) if row.ranked else 0
    return f"{text}, a tie of {tied + 1}" if tied else text


def _entry(row: Row) -> str:
    return f"{short(row.entry.title, MAX_TITLE)} ({row.entry.name})"


def _board_group(board: Board) -> str:
    return f"the suite {board.group}" if board.group in SUITES else board.group
