"""The documentation below the board: its header, and the search that finds the pages of both."""

import subprocess
import sys
from pathlib import Path
from typing import Literal

import pytest

from .made_site import Browser, Page
from .test_layout import SERIOUS, WIDE, axe

ROOT = Path(__file__).parents[3]
MASTHEAD = ".masthead, .masthead .mark a, .masthead li:first-child a"
PLACES = """(selector) => [...document.querySelectorAll(selector)]
  .flatMap((e) => [e.getBoundingClientRect().x, getComputedStyle(e).color])
  .concat(getComputedStyle(document.body).backgroundColor)"""
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def documentation(site: Path) -> None:
    """The documentation in the folder of the site."""
    pytest.importorskip("material", reason="mkdocs is not installed (extra `docs`)")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(site / "docs")]
    subprocess.run(command, cwd=ROOT, check=True)


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("HopperWall", "tasks/hopperwall-v0.html"),
        ("hopper wall", "tasks/hopperwall-v0.html"),
        ("keeper", "submissions/keeper.html"),
        ("retention map", "metrics.html#retention"),
        ("conformance kit", "docs/metrics.html#the-conformance-kit"),
    ],
)
def test_a_search_finds_pages_first_and_works_from_files(
    page: Page, address: str, words: str, found: str
) -> None:
    page.goto(f"{address}groups/hopper-gravity-v0.html")
    page.get_by_role("searchbox").fill(words)
    page.get_by_role("searchbox").press("Enter")
    page.locator(".found a").first.wait_for()
    links = page.locator(".found a").evaluate_all("(all) => all.map((each) => each.href)")
    assert f"{address}{found}" in links[:5]
    kinds = page.locator("h2").evaluate_all("(all) => all.map((each) => each.textContent.split(':')[0])")
    assert kinds == sorted(kinds, key=["Pages", "Documentation", "Decisions and the project"].index)


def test_a_page_of_the_documentation_loads_no_index(page: Page, http_address: str) -> None:
    loaded = list[str]()
    page.on("response", lambda reply: loaded.append(reply.url))
    page.goto(f"{http_address}docs/submit.html")
    page.wait_for_load_state("networkidle")
    assert [url for url in loaded if "search" in url or not url.startswith((http_address, "data:"))] == []


def test_an_address_without_a_page_shows_one_at_any_depth(page: Page, http_address: str) -> None:
    content = page.request.get(f"{http_address}404.html").text()
    page.route("**/nothing*", lambda route: route.fulfill(status=404, body=content, content_type="text/html"))
    for path in ("nothing.html", "submissions/some/nothing.html", "docs/nothing"):
        page.goto(http_address + path)
        colour = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert colour == "rgb(253, 253, 251)", "the style sheet is loaded"
        assert page.locator(".mark a").evaluate("(link) => link.href") == f"{http_address}index.html"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_has_the_masthead_in_the_place_that_it_has_on_the_board(
    browser: Browser, http_address: str, scheme: Literal["light", "dark"]
) -> None:
    places = []
    for path in ("metrics.html", "docs/metrics.html"):
        context = browser.new_context(viewport={"width": 1300, "height": 900}, color_scheme=scheme)
        page = context.new_page()
        page.goto(http_address + path)
        places.append(page.evaluate(PLACES, MASTHEAD))
        context.close()
    assert places[0] == places[1]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [360, 1300])
def test_pages_are_accessible_and_fit_the_screen(
    page: Page, http_address: str, width: int, scheme: Literal["light", "dark"]
) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    page.emulate_media(color_scheme=scheme)
    for path in ("submit", "learners", "api/envs", "environments/hopper"):
        page.goto(f"{http_address}docs/{path}.html")
        assert page.evaluate(WIDE) == []
        page.evaluate(axe())
        assert page.evaluate(SERIOUS.replace("{ exclude: [excluded] }", "document"), [None, {}]) == []
