"""The pictures of tasks and groups, copied from the package."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.views.pictures import pictures


def publish(_site: Leaderboard, _render: Render) -> Iterator[File]:
    """Every picture file."""
    for file in pictures().values():
        yield f"pictures/{file.name}", file.read_bytes()


PAGE = Page(title="Pictures", order=90, publish=publish)
