"""Figures and tables can be saved, from files as well: as SVG with its style, as PNG and as CSV."""

import csv
import re
from pathlib import Path
from xml.etree import ElementTree

from .made_site import Page, Visit


def saved(page: Page, kind: str, nth: int = 0) -> Path:
    """The file that a link below a figure or table saves."""
    with page.expect_download() as download:
        page.locator(f".take button:text-is('{kind}')").nth(nth).click()
    return download.value.path()


def test_a_figure_is_saved_with_its_style_inside(visit: Visit) -> None:
    page = visit("core.html")
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.locator(".method").first.evaluate("(e) => { e.style.fill = 'color-mix(in srgb, red 50%, blue)'; }")
    drawing = ElementTree.fromstring(saved(page, "SVG").read_text("utf-8"))
    points = [each for each in drawing.iter() if each.get("class", "").startswith("method")]
    assert len(points) >= 2
    assert all(point.get("fill", "").startswith("rgb(") for point in points)
    content = saved(page, "PNG").read_bytes()
    assert content.startswith(b"\x89PNG")
    assert int.from_bytes(content[16:20]) == 3 * int(float(drawing.get("width", "0")))
    assert said == []


def test_a_saved_line_has_the_place_that_the_page_gives_it(visit: Visit) -> None:
    page = visit("submissions/agile.html")
    page.get_by_role("button", name="Replay").first.click()
    page.locator(".watch.playing").wait_for()
    with page.expect_download() as download:
        page.locator(".watch.playing .take button").first.dispatch_event("click")
    assert ElementTree.parse(download.value.path()).getroot().get("display") is None, (
        "while the canvas is shown"
    )
    with page.expect_download() as download:
        page.locator(".panels .take button").first.dispatch_event("click")
    (line,) = [e for e in ElementTree.parse(download.value.path()).iter() if e.get("class") == "bold"]
    assert line.get("transform") == "matrix(0.5, 0, 0, 0.5, 0, 0)"


def test_buttons_are_named_after_what_they_save(visit: Visit) -> None:
    page = visit("submissions/agile.html")
    said = page.locator(".take button").evaluate_all("(all) => all.map((each) => each.ariaLabel)")
    assert not [each for each in said if re.search(r"-(figure|table)-\d", each)]
    assert "Save “Metrics: mean over runs, 95 % interval, one dot per run” as CSV" in said
    panel = page.locator(".panels figure").first
    caption = " ".join(panel.locator("figcaption").inner_text().split())
    assert panel.locator(".take button").first.get_attribute("aria-label") == f"Save “{caption}” as SVG"


def test_a_part_of_a_table_that_is_hidden_is_not_saved(visit: Visit) -> None:
    page = visit("index.html")
    page.locator("#core-table tbody").first.evaluate("(body) => { body.hidden = true; }")
    rows = list(csv.reader(saved(page, "CSV").read_text("utf-8-sig").splitlines()))
    assert [row[0] for row in rows] == ["Rank"]


CHANGED = """(texts) => {
  const cells = document.querySelectorAll("main table td:last-child");
  texts.forEach((text, i) => { cells[i].textContent = text; });
}"""
CELLS = ("\u22120.42 \u22120.50 to \u22120.34", "1\u202f000", "\u22123", "-3+cmd|x", "=1")
"""Numbers, and what a spreadsheet would run, in the last column."""


def test_a_table_is_saved_as_it_is_shown(visit: Visit) -> None:
    page = visit("submissions.html")
    page.evaluate(CHANGED, CELLS)
    rows = list(csv.reader(saved(page, "CSV").read_text("utf-8-sig").splitlines()))
    assert len(rows) == page.locator("main table tr").count()
    assert [row[-1] for row in rows[1:6]] == ["-0.42 -0.50 to -0.34", "1000", "-3", "'-3+cmd|x", "'=1"]
    assert rows[0] == ["Submission", "Level", "Groups", "Date", "Core score"]
    assert all(len(row) == len(rows[0]) for row in rows)
