"""What a kind of page is: the files that it writes, and what fills its templates."""

import posixpath
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property, partial
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from gym_extensions.catalog.tasks import TASKS
from gym_extensions.metrics.formulas import BY_NAME, COLUMNS, CORE_METRICS
from gym_extensions.references import References
from gym_extensions.scoring.group_score import PAPER_COLUMNS
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import FOLDER, paths, submission_results, text
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.charts import line_charts, strips, task_pictures
from gym_extensions.site.pages import core, landscapes
from gym_extensions.site.play import assets, watch
from gym_extensions.submissions import diagnostics, review

TASK_LIST = "tasks.html"
"""The page that lists all tasks."""
NETWORK_TITLES = {"ranks": "Rank", "inactive": "Inactive"}
DOCS = "docs/"
"""The folder of the documentation: in the site, built by mkdocs, and in the repository."""


def doc_link(file: str, title: str, root: str | None) -> Markup:
    """A link to a page of the documentation; without one, its title and its file in the repository.

    Args:
        file: its file in ``docs/``, with the anchor if there is one, for example ``metrics.md#ranks``.
        title: the text of the link.
        root: leads from the page to the root of the site; None if the site has no documentation.
    """
    name, _, anchor = file.partition("#")
    if root is None:
        return Markup("{} (<code>{}{}</code>)").format(title, DOCS, name)
    page = name.replace("README.md", "index.md").replace(".md", ".html")
    address = f"{root}{DOCS}{page}{f'#{anchor}' if anchor else ''}"
    return Markup('<a href="{}">{}</a>').format(address, title)


@cache
def environment() -> Environment:
    """The templates, compiled once. All values are escaped, and an unknown name is an error."""
    templates = Environment(
        loader=FileSystemLoader(FOLDER / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        auto_reload=False,
    )
    filters = (text.fixed, text.grouped, text.readable, text.short, text.task)
    templates.filters |= {function.__name__: function for function in filters}
    templates.globals.update(
        paths=paths,
        text=text,
        results=submission_results,
        core=core,
        landscape_charts=landscapes,
        network_titles=NETWORK_TITLES,
        line_charts=line_charts,
        strips=strips,
        task_pictures=task_pictures,
        stroboscopes=watch.stroboscopes,
        episode_dots=watch.episode_dots,
        board_columns=COLUMNS,
        core_metrics=CORE_METRICS,
        metrics=BY_NAME,
        paper_columns=PAPER_COLUMNS,
        reported=review.REPORTED,
        TRAINED_HERE=review.TRAINED_HERE,
        TASKS=TASKS,
    )
    return templates


@dataclass(frozen=True)
class Render:
    """Fills the templates with the menu and what every page shows.

    Args:
        references: the references that normalize all scores.
        pages: all kinds of pages.
        folders: of submissions by name, where they are known: pages show their poses, landscapes, diagnostics
            and policies. All of these files can be read.
        simulator: MuJoCo for the browser; without it the page Play says that it is missing.
        source: where the data is from.
        docs: whether pages link to the documentation, which is built into ``docs/`` of the site afterwards.
    """

    references: References
    pages: "tuple[Page, ...]"
    folders: Mapping[str, Path] = field(default_factory=dict)
    simulator: assets.Simulator | None = None
    source: paths.Source = paths.NOWHERE
    docs: bool = False

    @cached_property
    def landscapes(self) -> landscapes.Landscapes:
        """The landscapes of all submissions whose folders are known."""
        return landscapes.Landscapes(self.folders)

    @cached_property
    def networks(self) -> dict[str, dict[str, dict[str, diagnostics.Change]]]:
        """What training did to the networks of submissions whose folders are known, by name and group id."""
        return {name: diagnostics.changes(folder) for name, folder in self.folders.items()}

    def __call__(self, template: str, path: str, **values: object) -> str:
        """The text of the page at ``path``."""
        relative = posixpath.relpath(".", posixpath.dirname(path) or ".")
        root = Markup("" if relative == "." else f"{relative}/")
        links = [(page, page.doc if self.docs and page.doc else page.path) for page in self.pages]
        return (
            environment()
            .get_template(template)
            .render(
                references=self.references,
                menu=[(page.title, link) for page, link in links if link and not page.in_footer],
                footer=[(page.title, link) for page, link in links if link and page.in_footer],
                path=path,
                root=root,
                docs=self.docs,
                source=self.source,
                doc=partial(doc_link, root=root if self.docs else None),
                play_group_link=assets.play_group_link if self.simulator else lambda *_: "",
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
