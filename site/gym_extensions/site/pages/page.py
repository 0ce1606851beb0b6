"""What a kind of page is: the files that it writes, and the function that fills its templates."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

from markupsafe import Markup

from gym_extensions.scoring.scorecard import ReferencesInfo, Scorecard
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.landscapes import Landscapes
from gym_extensions.site.play.mujoco_wasm import Simulator
from gym_extensions.site.templating import environment

TASK_LIST = "tasks.html"
"""The page that lists all tasks."""
DOCS = "docs/"
"""The folder of the documentation: in the site, built by mkdocs, and in the repository."""


def doc_link(file: str, title: str, root: str | None) -> Markup:
    """A link to a page of the documentation; without one, the name of its file in the repository.

    Args:
        file: its file in ``docs/``, with the anchor if there is one, for example ``metrics.md#ranks``.
        title: the text of the link.
        root: leads from the page to the root of the site; None if the site has no documentation.
    """
    name, _, anchor = file.partition("#")
    if root is None:
        return Markup("<code>{}{}</code>").format(DOCS, name)
    address = f"{root}{DOCS}{name.removesuffix('.md')}.html{f'#{anchor}' if anchor else ''}"
    return Markup('<a href="{}">{}</a>').format(address, title)


@dataclass(frozen=True)
class Render:
    """Fills the templates with the menu and what every page shows."""

    references: ReferencesInfo  # that normalize all scores
    pages: tuple[Page, ...]  # all kinds
    folders: Mapping[str, Path] = field(
        default_factory=dict
    )  # of the submissions by name, where they are known
    simulator: Simulator | None = None  # MuJoCo for the browser, if the site has it
    docs: bool = False  # whether pages link to the documentation, which is in ``docs/`` of the site

    @cached_property
    def landscapes(self) -> Landscapes:
        """The landscapes of all submissions whose folders are known."""
        return Landscapes(self.folders)

    def __call__(self, template: str, path: str, **values: object) -> str:
        """The text of the page at ``path``."""
        relative = posixpath.relpath(".", posixpath.dirname(path) or ".")
        root = Markup("" if relative == "." else f"{relative}/")
        linked = [(page, page.link(self.docs)) for page in self.pages if page.link(self.docs)]
        return (
            environment()
            .get_template(template)
            .render(
                references=self.references,
                menu=[(page.title, link) for page, link in linked if not page.in_footer],
                footer=[(page.title, link) for page, link in linked if page.in_footer],
                path=path,
                root=root,
                docs=self.docs,
                doc=partial(doc_link, root=root if self.docs else None),
                **values,
            )
        )


File = tuple[str, str | bytes]
"""A path and its content."""


@dataclass(frozen=True)
class Page:
    """A kind of page.

    ``publish`` yields the files that are made from all submissions, of which it gets shortened scorecards, so
    that many fit in memory. ``publish_submission`` yields the files of one submission, from its whole
    scorecard.
    """

    title: str  # in the menu
    path: str = ""  # what the menu links to; without it the page is not in the menu
    publish: Callable[[Leaderboard, Render], Iterator[File]] | None = None
    publish_submission: Callable[[Scorecard, Render], Iterator[File]] | None = None
    in_footer: bool = False  # whether the footer links to it instead of the menu
    doc: str = ""  # the page of the documentation that is linked instead, where the site has one

    def link(self, docs: bool) -> str:
        """What the menu or the footer links to, in a site with or without documentation; empty if nothing."""
        return self.doc if docs and self.doc else self.path
