"""All groups and suites, and a page for each: tasks, references, boards, the paper's numbers."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.addresses import group_path
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.views.group import groups

PATH = "groups.html"


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The list, then a page per group and suite, also of those that nobody entered."""
    members = groups(site.boards, site.entrants, site.references)
    yield PATH, render("groups.html", PATH, groups=members)
    for group in members:
        path = group_path(group.id)
        yield path, render("group.html", path, group=group)


PAGE = Page(title="Groups", order=5, path=PATH, publish=publish)
