"""The list of tasks, and a page for each: what it is, what differs, references and best entries."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from gym_extensions.catalog.registry import TASKS
from gym_extensions.site.addresses import task_path
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import Draft, File, Page, Render
from gym_extensions.site.tasks.task import TaskView, best_entries, by_base
from gym_extensions.site.views.reference import measured

PATH = "tasks.html"


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The list, then a page per published task."""
    yield PATH, render("tasks.html", PATH, bases=by_base())
    references, best = measured(site.references), best_entries(site.boards)
    for row in TASKS.values():
        path = task_path(row.id)
        view = TaskView(row, references.get(row.id), best.get(row.id, ()))
        yield path, Draft(view.inputs, partial(render, "task.html", path, task=view))


PAGE = Page(title="Tasks", order=7, path=PATH, publish=publish)
