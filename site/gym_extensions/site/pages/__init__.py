"""All kinds of pages, one module each; those that are little more than their template are here.

A page that is made from all submissions has ``publish``, one per submission ``publish_submission``.
"""

import base64
import hashlib
import json
from collections.abc import Iterator

from markupsafe import Markup

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.metrics import compute
from gym_extensions.references import References
from gym_extensions.site import board_views, paths
from gym_extensions.site.pages import changes, compare, data, numbers, overview, submissions, tasks
from gym_extensions.site.pages.page import DOCS, TASK_LIST, File, Page, Render
from gym_extensions.site.play.assets import VERSION, assets

SHOWN_ROWS = 20
"""Rows of a board on the page of its group, with drawings; the board's own table has all."""


def _groups(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """A page for each group and suite with its boards, and the table of all rows of every board."""
    known = site.references.tasks
    for group in site.groups:
        path = paths.group_path(group.id)
        landscapes = {board.id: render.landscapes.rows(board) for board in group.boards}
        values = {"landscapes": landscapes, "known": known, "shown_rows": SHOWN_ROWS}
        yield path, render("group.html", path, group=group, **values)
    for board in site.boards:
        path = paths.board_path(board.id)
        yield path, render("board.html", path, board=board)


def _play(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """The page on which MuJoCo runs in the browser, and its files; without the simulator it says so."""
    watch = paths.task_path("Hopper-v0")
    simulator = render.simulator
    files, absent = assets(site, render.folders, simulator) if simulator else ({}, {})
    values = {"play": simulator, "absent": absent, "watch": watch, "version": VERSION}
    yield "play.html", render("play.html", "play.html", **values)
    yield from files.items()


ROOT_OF_SITE = (
    'document.head.append(Object.assign(document.createElement("base"), {href: location.href.startsWith(URL) '
    "? URL : location.pathname.replace(/\\/(api|boards|docs|groups|pictures|play|schemas|static|submissions|"
    'tasks)\\/.*|\\/[^/]*$/, "/")}))'
)
"""The script of the page 404: links begin at URL, the site's address if that is known, or else at the folder
above the first of the site's own folders."""


def _search_and_404(_site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """The page that hosts show for an address without a page, and, with the documentation, the search."""
    script = ROOT_OF_SITE.replace("URL", json.dumps(f"{render.source.url}/").replace("<", r"\u003c"))
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    values = {"script": Markup(script), "digest": f"sha256-{digest}"}
    yield "404.html", render("404.html", "404.html", **values)
    if render.docs:
        yield "search.html", render("search.html", "search.html")


MATRIX = ((0.0, 0.1, 0.0), (0.8, 0.2, 0.1), (0.5, 0.9, 0.3), (0.4, 0.7, 1.0))
"""Of the worked example, p[s][j]: a row per stage from 0, a column per task."""
SINGLE, JOINT, CUMULATIVE = (0.8, 0.8, 0.9), 0.9, 0.95
"""p_single[j], the performance of joint training on every task, and p_cumulative[T]."""
AREAS, SINGLE_AREAS = (0.5, 0.6, 0.7), (0.5, 0.4, 0.5)
"""Areas under the training curves, in sequence and alone."""
SPREAD = 0.02
"""Distance of neighbouring episodes of a cell, which lie evenly around its mean."""


def _metrics(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """The definition of every number, with an anchor per metric and a worked example of three tasks."""
    offsets = [SPREAD * (at - (EVALUATION_EPISODES - 1) / 2) for at in range(EVALUATION_EPISODES)]
    found = compute(
        MATRIX,
        SINGLE,
        joint=[JOINT] * len(SINGLE),
        cumulative=CUMULATIVE,
        episodes=[[cell + offset for offset in offsets] for cell in MATRIX[-1]],
        auc=AREAS,
        single_auc=SINGLE_AREAS,
    )
    example = {"matrix": MATRIX, "single": SINGLE, "joint": JOINT, "areas": AREAS, "spread": SPREAD}
    values = {
        "used_budgets": {board.budget for board in site.boards},
        "example": example | {"single_areas": SINGLE_AREAS, "results": found},
    }
    yield "metrics.html", render("metrics.html", "metrics.html", **values)


PAGES = (
    Page("Overview", "index.html", overview.publish),
    Page("Core", "core.html"),
    Page("Groups", "groups.html", _groups),
    Page("Tasks", TASK_LIST, tasks.publish),
    Page("Submissions", "submissions.html", submissions.publish_list, submissions.publish_submission),
    Page("Compare", "compare.html", compare.publish),
    Page("Play", "play.html", _play),
    Page("Metrics", "metrics.html", _metrics),
    Page("Submit", "index.html#submit", doc=f"{DOCS}submit.html"),
    Page("Docs", doc=f"{DOCS}index.html"),
    Page("References", "references.html", tasks.publish_references, in_footer=True),
    Page("Data", "data.html", data.publish, data.publish_submission, in_footer=True),
    Page("Changes", "changes.html", changes.publish, in_footer=True),
    Page("Speed", doc=f"{DOCS}speed.html", in_footer=True),
    Page("Numbers", publish=numbers.publish),
    Page("Search", publish=_search_and_404),
    Page("Pictures", publish=tasks.publish_pictures),
)
"""All kinds of pages in the order of the menu."""


def docs_masthead(url: str, repository: str = "") -> str:
    """The masthead of a page of the documentation, ``docs/url``, with the menu of all other pages."""
    render = Render(References("", {}), PAGES, source=paths.Source(repository), docs=True)
    return render("masthead.html", f"{DOCS}{url}")
