"""The pages of groups and suites with their tasks and boards, and the table of all rows of every board."""

from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.catalog.groups import CORE, CORES, GROUPS, SUITES
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.site import board_views, paths, submission_results
from gym_extensions.site.charts.task_pictures import group_picture
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.pages.tasks import measured

SHOWN_ROWS = 20
"""Rows of a board on the page of its group, with drawings; the board's own table has all."""


def publish(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """A page for each group and suite with its boards, and the table of all rows of every board."""
    known = measured(site.references)
    for group in groups(site):
        path = paths.group_path(group.id)
        landscapes = {board.id: render.landscapes.rows(board) for board in group.boards}
        values = {"landscapes": landscapes, "known": known, "shown_rows": SHOWN_ROWS}
        yield path, render("group.html", path, group=group, **values)
    for board in site.boards:
        path = paths.board_path(board.id)
        yield path, render("board.html", path, board=board)


@dataclass(frozen=True)
class Group:
    """A group or suite."""

    id: str  # group id or suite name
    tasks: tuple[str, ...]  # task ids in training order; empty for a suite
    members: tuple[str, ...]  # the group ids of a suite; empty for a group
    # By protocol, most submissions first, task-conditioned ones after the others.
    boards: tuple[board_views.BoardView, ...]

    @property
    def picture(self) -> str:
        """The path of its picture; empty without one."""
        return group_picture(self.id)

    @property
    def summaries(self) -> tuple[str, ...]:
        """What its bodies are and do, one sentence per base body."""
        return tuple(dict.fromkeys(TASKS[task].body.prose.summary for task in self.tasks if task in TASKS))

    @property
    def submissions(self) -> int:
        """The number of different submissions on its boards."""
        return len({row.submission.name for board in self.boards for row in board.rows})

    @property
    def best(self) -> board_views.Row | None:
        """The first ranked submission of its first board of sequential training that has one."""
        leaders = (board.leader for board in self.boards if board.protocol == submission_results.SEQUENTIAL)
        return next((row for row in leaders if row and row.submission.ranked), None)


def groups(site: board_views.Leaderboard) -> tuple[Group, ...]:
    """The groups of the core, other published groups and those that have a board, then the suites."""
    by_group: dict[str, list[board_views.BoardView]] = {}
    for board in site.boards:
        by_group.setdefault(board.group, []).append(board)
    published = {group.id: group.task_ids for group in GROUPS.values()}
    ids = [name for name in dict.fromkeys((*CORES[CORE], *published, *by_group)) if name not in SUITES]
    found = []
    for name in (*ids, *SUITES):
        boards = by_group.get(name, [])
        tasks = published.get(name) or next((board.results[0].tasks for board in boards), ())
        boards.sort(key=lambda b: (PROTOCOLS.index(b.protocol), b.task_conditioned, -len(b.rows)))
        found.append(Group(name, tasks, SUITES.get(name, ()), tuple(boards)))
    return tuple(found)
