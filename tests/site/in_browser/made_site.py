"""The site of the browser tests: submissions of every level, long names, a long board, poses."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import pytest

from gym_extensions.references import load_references
from gym_extensions.site import SITE_ASSETS
from gym_extensions.site.build import Site
from gym_extensions.site.pages import PAGES as PAGES_OF_SITE
from gym_extensions.site.pages.page import Render
from gym_extensions.site.play.assets import load

from ..browser import typed
from ..conftest import everything, learner, make_submission, scored
from ..pages.test_core import GROUPS, method
from ..play.test_assets import write_runs
from ..play.test_watch import poses_of

if TYPE_CHECKING:
    from playwright import sync_api

Browser: TypeAlias = "sync_api.Browser"
BrowserContext: TypeAlias = "sync_api.BrowserContext"
Locator: TypeAlias = "sync_api.Locator"
Page: TypeAlias = "sync_api.Page"
Visit = Callable[[str], Page]
"""Types of the tests, by text: without playwright they are skipped."""

ASSETS = Path(__file__).parents[3] / SITE_ASSETS
"""The simulator of Play, where ``make site-assets`` has fetched it."""
TASK = "tasks/hopperwall-v0.html"
MANY = "many-"
"""The prefix of the submissions that fill a long board."""

PAGES = {
    "overview": "index.html",
    "core": "core.html",
    "group": "groups/hopper-gravity-v0.html",
    "suite": "groups/gravity.html",
    "board": "boards/hopper-gravity-v0-sequential-100k.html",
    "long board": "boards/walker2d-gravity-v0-sequential-100k.html",
    "tasks": "tasks.html",
    "task": TASK,
    "submissions": "submissions.html",
    "submission": "submissions/agile.html",
    "submission of several groups": "submissions/keeper.html",
    "refused submission": "submissions/broken.html",
    "compare": "compare.html",
    "play": "play.html",
    "metrics": "metrics.html",
    "data": "data.html",
    "references": "references.html",
}
"""One page of every kind, by path."""
for each in PAGES_OF_SITE:  # a page that somebody adds to the menu or the footer is tested as well
    if (path := each.path.partition("#")[0]) and path not in PAGES.values():
        PAGES[each.title] = path
QUICK = ("overview", "group", "submission")
"""The kinds that also run in ``make test``: text, a table with drawings, charts and players."""
KINDS = [
    pytest.param(path, id=kind, marks=() if kind in QUICK else pytest.mark.slow)
    for kind, path in PAGES.items()
]
"""The pages as parameters of tests."""


def write_site(folder: Path) -> Path:
    """Writes all files of the site."""
    document = everything()
    many = [_many(index) for index in range(52)]
    methods = [method("keeps", 0.8, 0.98), method("loses", 0.8, 0.5), method("lacks", 0.9, 0.9, GROUPS[:3])]
    methods[1]["title"] = "W" * 200
    document["submissions"] = sorted(document["submissions"] + many + methods, key=lambda each: each["name"])
    poses_of(document).write(write_runs(folder.parent / "agile") / "poses" / "hopper-gravity.json")
    folders = {"agile": folder.parent / "agile"}
    site = Site(Render(load_references(), PAGES_OF_SITE, folders, load(ASSETS), docs=True))
    for path, content in site.files(typed(document).submissions):
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content.encode() if isinstance(content, str) else content)
    return folder


def _many(index: int) -> dict[str, Any]:
    scores = scored("walker2d-gravity", learner(0.3 + index / 100, 0.9, 2))
    return make_submission(f"{MANY}{index:02d}", {"walker2d-gravity-v0": {"sequential": scores}})
