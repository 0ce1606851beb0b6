"""The documentation below the board: its header, and the search that finds the pages of both."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import pytest

from .test_layout import SERIOUS, WIDE, axe

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

ROOT = Path(__file__).parents[3]
MASTHEAD = ".masthead, .masthead .mark a, .masthead li:first-child a"
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
        ("keeper", "submissions/keeper.html"),
        ("retention map", "metrics.html#retention"),
        ("conformance kit", "docs/metrics.html#the-conformance-kit"),
    ],
)
def test_a_search_on_the_board_leads_to_its_pages_and_to_the_documentation(
    page: Page, http_address: str, words: str, found: str
) -> None:
    outside: list[str] = []
    ours = (http_address, "data:", "blob:")
    page.on("request", lambda made: None if made.url.startswith(ours) else outside.append(made.url))
    page.goto(f"{http_address}groups/hopper-gravity-v0.html")
    page.get_by_role("searchbox").fill(words)
    page.get_by_role("searchbox").press("Enter")
    page.locator(".md-search-result__item a").first.wait_for()
    links = page.locator(".md-search-result__link").evaluate_all("(all) => all.map((each) => each.href)")
    assert f"{http_address}{found}" in links[:5]
    assert outside == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_has_the_masthead_in_the_place_that_it_has_on_the_board(
    browser: Browser, http_address: str, scheme: Literal["light", "dark"]
) -> None:
    places = []
    for path in ("metrics.html", "docs/metrics.html"):
        context = browser.new_context(viewport={"width": 1300, "height": 900}, color_scheme=scheme)
        page = context.new_page()
        page.goto(http_address + path)
        places.append(
            page.evaluate(
                f"() => [...document.querySelectorAll('{MASTHEAD}')]"
                ".flatMap((e) => [e.getBoundingClientRect().x, getComputedStyle(e).color])"
                ".concat(getComputedStyle(document.body).backgroundColor)"
            )
        )
        context.close()
    assert places[0] == places[1]


@pytest.mark.parametrize("width", [360, 1300])
def test_the_header_is_accessible_and_fits_the_screen(page: Page, http_address: str, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    page.goto(f"{http_address}docs/submit.html")
    assert page.evaluate(WIDE) == []
    page.evaluate(axe())
    found = page.evaluate(SERIOUS.replace("{ exclude: [excluded] }", "excluded"), [".masthead", {}])
    assert found == []
