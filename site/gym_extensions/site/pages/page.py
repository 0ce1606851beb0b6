"""What a kind of page is: the files that it writes, and the function that fills its templates."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from markupsafe import Markup

from gym_extensions.scoring.scorecard import ReferencesInfo, Scorecard
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.landscapes import Landscapes
from gym_extensions.site.play.mujoco_wasm import Simulator
from gym_extensions.site.templating import environment

TASK_LIST = "tasks.html"
"""The page that lists all tasks; other pages link to the pages of tasks if the site has it."""


@dataclass(frozen=True)
class Render:
    """Fills the templates with the menu and what every page shows.

    Args:
        references: the references that normalize all scores.
        pages: all kinds of pages.
        inputs: the digest of the scorecard of every entry, by name.
        folders: the folders of the entries by name, where they are known.
        simulator: MuJoCo for the browser, if the site has it.
    """

    references: ReferencesInfo
    pages: tuple[Page, ...]
    inputs: Mapping[str, bytes] = field(default_factory=dict)
    folders: Mapping[str, Path] = field(default_factory=dict)
    simulator: Simulator | None = None

    @cached_property
    def landscapes(self) -> Landscapes:
        """The landscapes of all entries whose folders are known."""
        return Landscapes(self.folders)

    def __call__(self, template: str, path: str, **values: object) -> str:
        """The text of the page at ``path``."""
        relative = posixpath.relpath(".", posixpath.dirname(path) or ".")
        linked = [page for page in self.pages if page.path]
        return (
            environment()
            .get_template(template)
            .render(
                references=self.references,
                menu=[page for page in linked if not page.in_footer],
                footer=[page for page in linked if page.in_footer],
                has_task_pages=any(page.path == TASK_LIST for page in linked),
                path=path,
                root=Markup("" if relative == "." else f"{relative}/"),
                **values,
            )
        )


@dataclass(frozen=True)
class Draft:
    """A file that is written only if its inputs changed.

    Args:
        inputs: everything that the text depends on besides the code, the menu and the references.
        write: returns the text.
    """

    inputs: bytes
    write: Callable[[], str]


File = tuple[str, str | bytes | Draft]
"""A path and its content."""


@dataclass(frozen=True)
class Page:
    """A kind of page.

    Args:
        title: its name in the menu.
        path: the path that the menu links to; without it the page is not in the menu.
        publish: yields the files that are made from all entries. It gets shortened scorecards, so that many
            fit in memory.
        publish_entry: yields the files of one entry, from its whole scorecard.
        in_footer: whether the footer links to it instead of the menu.
    """

    title: str
    path: str = ""
    publish: Callable[[Leaderboard, Render], Iterator[File]] | None = None
    publish_entry: Callable[[Scorecard, Render], Iterator[File]] | None = None
    in_footer: bool = False
