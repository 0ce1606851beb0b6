"""The pictures of tasks and groups: copied from the package, or drawn from maps."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.sheets import sheet
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.motion.maps import map_file
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.views.pictures import map_picture, pictures


def publish(_site: Leaderboard, _render: Render) -> Iterator[File]:
    """Every picture file, and a map per course."""
    for file in pictures().values():
        yield f"pictures/{file.name}", file.read_bytes()
    names = set[str]()
    for task in TASKS.values():
        name, facts = map_picture(task), sheet(task.id)
        if facts is not None and name and name not in names:
            names.add(name)
            yield f"pictures/{name}", map_file(facts)


PAGE = Page(title="Pictures", order=90, publish=publish)
