"""Where the reader's system prescribes all colours, every mark that carries meaning stays visible."""

from collections.abc import Iterator

import pytest

from .made_site import PAGES, Browser, Page

CONTRAST = """const parts = (colour) => (colour.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
const paper = parts(getComputedStyle(document.body).backgroundColor);
const over = (colour, share = 1) => {
  const [r, g, b, a = 1] = parts(colour);
  return [r, g, b].map((channel, at) => channel * a * share + paper[at] * (1 - a * share));
};
const luminance = (rgb) => rgb.map((part) => part / 255)
  .map((part) => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)
  .reduce((sum, part, at) => sum + part * [0.2126, 0.7152, 0.0722][at], 0);
const contrast = (first, second) => {
  const [dark, light] = [luminance(first), luminance(second)].sort((a, b) => a - b);
  return (light + 0.05) / (dark + 0.05);
};
const onPaper = (colour, share) => colour === "none" ? 1 : contrast(over(colour, share), paper);
const shown = [...document.querySelectorAll("main *")].filter((e) => e.checkVisibility());
const report = (elements) => elements.map((e) => e.outerHTML.slice(0, 120)).slice(0, 5);
"""
MARKS = (
    ".interval, .run, .mean, .join, .line, .thin, .bold, .stop, .at, .episodes, .cell-mean, .reference-floor"
)
FAINT_MARKS = f"""() => {{ {CONTRAST}
  return report(shown.filter((e) => e.matches("{MARKS}")).filter((e) => {{
    const style = getComputedStyle(e);
    return Math.max(onPaper(style.stroke, style.strokeOpacity), onPaper(style.fill, style.fillOpacity)) < 3;
  }}));
}}"""
FAINT_DRAWINGS = f"""() => {{ {CONTRAST}
  return report(shown.filter((e) => e.matches("svg.strobe")).filter((e) =>
    Math.max(...[...e.querySelectorAll("path")].map((path) => onPaper(getComputedStyle(path).stroke))) < 3));
}}"""
HIDDEN_RUNS = f"""() => {{ {CONTRAST}
  return report(shown.filter((e) => e.matches(".run")).filter((e) => {{
    const bar = e.parentElement.querySelector(".interval");
    return bar && getComputedStyle(bar).stroke === getComputedStyle(e).fill;
  }}));
}}"""
UNREADABLE_CELLS = f"""() => {{ {CONTRAST}
  return report(shown.filter((e) => e.matches(".heat td")).filter((e) => {{
    const style = getComputedStyle(e);
    return contrast(over(style.color), over(style.backgroundColor)) < 4.5;
  }}));
}}"""
LOST_MEANING = f"""() => {{ {CONTRAST}
  return report(shown.filter((e) => {{
    const style = getComputedStyle(e), is = (selector) => e.matches(selector);
    if (is(".heat td.unsure, .swatch.unsure")) return !style.backgroundImage.includes("gradient");
    if (is("[class^=lost], [class^=won], td.below, .swatch")) return style.boxShadow === "none";
    const {{ borderTopWidth: width, borderTopColor: border }} = style;
    if (is(".badge")) return !parseFloat(width) || onPaper(border) < 3;
    return is("[type=checkbox]") && (style.appearance === "none" || style.forcedColorAdjust === "none");
  }}));
}}"""
FAINT_FOCUS = f"""() => {{ {CONTRAST}
  const controls = document.querySelectorAll("a[href], button:enabled, input, select, summary, [tabindex]");
  return report([...controls].filter((e) => e.checkVisibility()).slice(0, 40).filter((e) => {{
    e.focus();
    const {{ outlineStyle, outlineWidth, outlineColor }} = getComputedStyle(e);
    return outlineStyle === "none" || parseFloat(outlineWidth) < 1 || onPaper(outlineColor) < 3;
  }}));
}}"""
CHECKS = {
    "marks": FAINT_MARKS,
    "stroboscopes": FAINT_DRAWINGS,
    "runs on their interval": HIDDEN_RUNS,
    "numbers in cells": UNREADABLE_CELLS,
    "hatching, signs, badges, ticks": LOST_MEANING,
}


@pytest.fixture(scope="module", params=["light", "dark"])
def forced(browser: Browser, request: pytest.FixtureRequest) -> Iterator[Page]:
    """A page with forced colours, in the light and the dark scheme of Chromium."""
    context = browser.new_context(forced_colors="active", color_scheme=request.param)
    context.set_default_timeout(120_000)
    yield context.new_page()
    context.close()


@pytest.mark.parametrize("kind", ["group", "submission"])
def test_marks_badges_and_focus_are_visible(forced: Page, address: str, kind: str) -> None:
    forced.goto(address + PAGES[kind])
    assert {name: forced.evaluate(code) for name, code in CHECKS.items()} == {name: [] for name in CHECKS}
    forced.keyboard.press("Tab")
    assert forced.evaluate(FAINT_FOCUS) == []


def test_the_page_of_the_menu_is_marked(forced: Page, address: str) -> None:
    forced.goto(f"{address}index.html")
    current = forced.locator("[aria-current]")
    assert current.evaluate("(e) => parseFloat(getComputedStyle(e).borderBottomWidth)") >= 2
