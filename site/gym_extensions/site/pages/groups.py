"""The pages of groups and suites with their tasks and boards, and the table of all rows of every board."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from gym_extensions.catalog.groups import CORE, CORES, GROUPS, SUITES, TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.references import MeasuredReference
from gym_extensions.scoring.scorecard import PaperRow, Scorecard
from gym_extensions.site import paths
from gym_extensions.site.board_views import BoardView, Leaderboard, Row
from gym_extensions.site.charts.task_pictures import group_picture, task_picture
from gym_extensions.site.pages.landscapes import TITLES
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.pages.tasks import measured
from gym_extensions.site.submission_results import SEQUENTIAL
from gym_extensions.site.text import fixed
from gym_extensions.submissions.review import REPORTED

SHOWN_ROWS = 20
"""Rows of a board on the page of its group, with drawings; the board's own table has all."""
FIRST_SUBMISSIONS = 2
"""How many of the best submissions are compared with the paper's numbers."""


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """A page for each group and suite with its boards, and the table of all rows of every board."""
    for group in groups(site):
        path = paths.group_path(group.id)
        landscapes = {board.id: render.landscapes.rows(board) for board in group.boards}
        values = {"landscapes": landscapes, "landscape_titles": TITLES, "shown_rows": SHOWN_ROWS}
        yield path, render("group.html", path, group=group, **values)
    for board in site.boards:
        path = paths.board_path(board.id)
        yield path, render("board.html", path, board=board)


@dataclass(frozen=True)
class TaskRow:
    """A task of a group, with its picture and how its floor and expert were measured."""

    task: str
    picture: str
    measured: MeasuredReference | None

    @property
    def has_page(self) -> bool:
        """Whether the task is published, so that it has a page."""
        return self.task in TASKS

    @property
    def one(self) -> str:
        """What a score of 1 means, in words."""
        if self.measured is None:
            return "No reference has been measured"
        expert, attempts = self.measured.expert, self.measured.attempts
        if expert:
            provisional = f" (provisional: {expert.provisional})" if expert.provisional else ""
            return f"1 = {expert.agent or 'expert'}: return {_number(expert.mean)}{provisional}"
        tried = f"; the best attempt returns {_number(attempts.mean)}" if attempts else ""
        return f"Open: no expert is known that is clearly better than 0{tried}"

    @property
    def zero(self) -> str:
        """What a score of 0 means, in words."""
        if self.measured is None:
            return ""
        floor = self.measured.floor
        agent = {"zero": "the zero action", "random": "random actions"}.get(floor.agent, floor.agent)
        return f"0 = {agent}: return {_number(floor.mean)}"


@dataclass(frozen=True)
class PaperTable:
    """The four columns of the paper for some submissions, per task."""

    submissions: tuple[tuple[str, str], ...]  # name and title of each, the publication first
    rows: tuple[tuple[str, tuple[PaperRow | None, ...]], ...]  # per task id; None where a submission lacks it


@dataclass(frozen=True)
class Group:
    """A group or suite."""

    id: str  # group id or suite name
    tasks: tuple[TaskRow, ...]  # in training order; empty for a suite
    members: tuple[str, ...]  # the group ids of a suite; empty for a group
    # By protocol, most submissions first, task-conditioned ones after the others.
    boards: tuple[BoardView, ...]
    paper: PaperTable | None  # the paper's columns; None without a publication

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
    def submissions(self) -> int:
        """The number of different submissions on its boards."""
        return len({row.submission.name for board in self.boards for row in board.rows})

    @property
    def best(self) -> Row | None:
        """The first ranked submission of its first board of sequential training that has one."""
        leaders = (board.leader for board in self.boards if board.protocol == SEQUENTIAL)
        return next((leader.row for leader in leaders if leader and leader.row.submission.ranked), None)


def groups(site: Leaderboard) -> tuple[Group, ...]:
    """The groups of the core, other published groups and those that have a board, then the suites."""
    by_group: dict[str, list[BoardView]] = {}
    for board in site.boards:
        by_group.setdefault(board.group, []).append(board)
    published = {group.id: group for group in GROUPS.values()}
    ids = [name for name in dict.fromkeys((*CORES[CORE], *published, *by_group)) if name not in SUITES]
    known = measured(site.references)
    return tuple(
        _group(name, published.get(name), by_group.get(name, []), site.submissions, known)
        for name in (*ids, *SUITES)
    )


def _group(
    name: str,
    group: TaskGroup | None,
    boards: Sequence[BoardView],
    submissions: Sequence[Scorecard],
    known: Mapping[str, MeasuredReference],
) -> Group:
    tasks = group.task_ids if group else next((board.results[0].tasks for board in boards), ())
    return Group(
        id=name,
        tasks=tuple(TaskRow(task, task_picture(task), known.get(task)) for task in tasks),
        members=SUITES.get(name, ()),
        boards=tuple(
            sorted(boards, key=lambda b: (PROTOCOLS.index(b.protocol), b.task_conditioned, -len(b.rows)))
        ),
        paper=_paper(name, tasks, boards, submissions),
    )


def _paper(
    name: str, tasks: Sequence[str], boards: Sequence[BoardView], submissions: Sequence[Scorecard]
) -> PaperTable | None:
    """Publications of the group, and the best submissions of its first board of sequential training."""
    reported = [
        submission
        for submission in submissions
        if submission.level == REPORTED and SEQUENTIAL in submission.groups.get(name, {})
    ]
    if not reported:
        return None
    sequential = next((board for board in boards if board.protocol == SEQUENTIAL), None)
    best = [row.card for row in sequential.rows[:FIRST_SUBMISSIONS]] if sequential else []
    cards = [*reported, *(card for card in best if card not in reported)]
    tables = [{row.task: row for row in card.groups[name][SEQUENTIAL].paper_table} for card in cards]
    rows = tuple((task, tuple(table.get(task) for table in tables)) for task in tasks)
    return PaperTable(tuple((card.name, card.title) for card in cards), rows)


def _number(value: float) -> str:
    return fixed(value, 0 if abs(value) >= 10 else 2)
