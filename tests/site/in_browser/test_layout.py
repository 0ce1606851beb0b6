"""Every kind of page on small and large screens, on paper, and for the keyboard. Each page is loaded once.

Most kinds are marked ``slow``; ``make browser`` runs them.
"""

import json
from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import pytest

from .made_site import KINDS, MANY, Browser, Page

Screens = dict[int, dict[str, list[str]]]
"""The findings by width and check."""
WIDTHS = (320, 360, 768, 1300, 1920)
PAPER = 1032
"""Width in pixels of A4 landscape less its margins."""

WIDE = """() => document.documentElement.scrollWidth <= innerWidth ? [] : [innerWidth,
  ...[...document.querySelectorAll("main *, header *, footer *")]
    .filter((e) => e.getBoundingClientRect().right > innerWidth + 1 && !e.closest(".scroll"))
    .map((e) => `${e.tagName}.${e.getAttribute("class") || ""} ${e.textContent.trim().slice(0, 40)}`)
    .slice(0, 8)]"""
UNMARKED = """() => [...document.querySelectorAll(".scroll")].filter((e) => {
  if (!e.checkVisibility()) return false;
  const cut = e.scrollWidth > e.clientWidth + 1, faded = getComputedStyle(e).maskImage !== "none";
  return cut !== faded;
}).map((e) => e.textContent.trim().slice(0, 60))"""
CONTROLS = "a[href], button, input, select, summary"
EMPTY_STOPS = """(controls) => [...document.querySelectorAll(`${controls}, [tabindex]`)].filter((e) => {
  if (e.tabIndex < 0 || e.disabled || !e.checkVisibility({ visibilityProperty: true })) return false;
  if (!e.matches(controls)) return e.scrollWidth <= e.clientWidth + 1 && e.scrollHeight <= e.clientHeight + 1;
  const box = e.getBoundingClientRect(), name = (e.getAttribute("aria-label") || e.textContent || "").trim();
  const named = name || (e.labels && e.labels.length) || e.querySelector("img[alt]:not([alt=''])");
  return !named || box.width < 1 || box.height < 1;
}).map((e) => e.outerHTML.slice(0, 120))"""
TARGETS = (
    "nav a, footer a, thead a, tbody th > a, tbody td > a, li > a:first-child, dd > a, summary, button, "
    "select, input"
)
LOW_TARGETS = """(targets) => [...document.querySelectorAll(targets)].filter((e) =>
    e.checkVisibility({ visibilityProperty: true }) && e.getBoundingClientRect().height < 23.9
    && !(/checkbox|radio/.test(e.type) && e.closest("label, th")))
  .map((e) => `${e.getBoundingClientRect().height} ${e.outerHTML.slice(0, 120)}`).slice(0, 10)"""
SERIOUS = """([excluded, only]) => axe.run({ exclude: [excluded] }, { resultTypes: ["violations"], ...only })
  .then(({ violations }) => violations
  .filter(({ impact }) => ["moderate", "serious", "critical"].includes(impact))
  .map(({ id, nodes: [first] }) => `${id}: ${first.html.slice(0, 160)} ${first.failureSummary}`))"""
"""Violations of at least moderate impact, on the whole page apart from copies of rows."""


SMALL = """() => [...document.querySelectorAll("main svg text")].filter((e) => e.checkVisibility())
  .map((e) => [e, e.getScreenCTM()])
  .map(([e, { a, b }]) => [parseFloat(getComputedStyle(e).fontSize) * Math.hypot(a, b), e])
  .filter(([size]) => size && size < 9.5)
  .map(([size, e]) => `${size} ${e.closest("svg").getAttribute("class")} ${e.textContent}`).slice(0, 5)"""
CUT_CAPTIONS = """() => [...document.querySelectorAll(".scroll caption")].filter((e) => {
  const region = e.closest(".scroll"), style = getComputedStyle(region);
  if (!e.checkVisibility()) return false;
  const whole = style.maskImage === "none" ? Infinity : parseFloat(style.getPropertyValue("--caption"));
  return whole < e.offsetHeight || e.getBoundingClientRect().right > region.getBoundingClientRect().right + 1;
}).map((e) => e.textContent)"""
COPIES = f"[data-submission^={MANY}]:nth-child(n+13), .lean tbody tr:nth-child(n+13)"
"""The rows of a long table that differ from the rows before them in their numbers alone."""
ON_SCREEN = {
    "wider than the screen": WIDE,
    "cut without a mark": UNMARKED,
    "cut captions": CUT_CAPTIONS,
    "small text of drawings": SMALL,
    "low targets": f"() => ({LOW_TARGETS})({json.dumps(TARGETS)})",
}


@pytest.fixture(scope="module", params=KINDS)
def opened(browser: Browser, address: str, request: pytest.FixtureRequest) -> Iterator[Page]:
    """Each page in turn, from its file."""
    context = browser.new_context(viewport={"width": 1300, "height": 900})
    context.set_default_timeout(120_000)
    page = context.new_page()
    page.goto(address + request.param)
    yield page
    context.close()


@pytest.fixture(scope="module")
def screens(opened: Page) -> Screens:
    """What each check of ``ON_SCREEN`` reports at each width. Every layout takes time: each is made once."""
    code = f"() => ({{{', '.join(f'{json.dumps(name)}: ({check})()' for name, check in ON_SCREEN.items())}}})"
    findings: Screens = {}
    for width in WIDTHS:
        opened.set_viewport_size({"width": width, "height": 900})
        findings[width] = settled(opened, code)
    opened.set_viewport_size({"width": 1300, "height": 900})
    return findings


@pytest.fixture
def media(opened: Page) -> Iterator[Page]:
    """The page; its media are as before afterwards."""
    yield opened
    opened.emulate_media(media="screen", color_scheme="light", forced_colors="none")
    opened.set_viewport_size({"width": 1300, "height": 900})


def axe() -> str:
    """The script of axe-core. Without a browser its package need not be installed."""
    return (files("axe_playwright_python") / "axe.min.js").read_text("utf-8")


def settled(page: Page, code: str, argument: object = None) -> Any:
    """The value of an expression after the next two frames, when scripts have seen the new size."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.evaluate(code, argument)


@pytest.mark.parametrize("width", WIDTHS)
def test_no_page_is_wider_than_the_screen_or_has_low_targets(screens: Screens, width: int) -> None:
    assert screens[width] == {check: [] for check in ON_SCREEN}


def test_every_tab_stop_is_visible_and_named(opened: Page) -> None:
    assert settled(opened, EMPTY_STOPS, CONTROLS) == []


def test_no_page_is_wider_than_the_paper(media: Page) -> None:
    media.emulate_media(media="print")
    media.set_viewport_size({"width": PAPER, "height": 720})
    assert settled(media, WIDE) == []
    assert media.locator(".tools:visible, nav:visible, .skip:visible").count() == 0


def test_axe_reports_nothing_serious_or_moderate(opened: Page) -> None:
    opened.evaluate(axe())
    assert opened.evaluate(SERIOUS, [COPIES, {}]) == []


def test_contrast_suffices_in_the_dark(media: Page) -> None:
    media.evaluate(axe())
    media.emulate_media(color_scheme="dark")
    assert media.evaluate(SERIOUS, [COPIES, {"runOnly": ["color-contrast"]}]) == []
