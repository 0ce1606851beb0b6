"""The table of a board, the tabs of a group and Compare in a browser; their state is in the address."""

import csv
from pathlib import Path

import pytest

from .made_site import MANY, PAGES, Locator, Page, Visit

BOARD, ALL_ROWS, GROUP = PAGES["board"], PAGES["long board"], PAGES["group"]
SHOWN = ".wide tbody:not(.computed) tr:not([hidden])"


def names(page: Page) -> list[str]:
    """The folders of the shown submissions, from top to bottom."""
    found: list[str] = page.eval_on_selector_all(
        SHOWN, "rows => rows.map((row) => row.querySelector('i').textContent)"
    )
    return found


def wait_for_rows(page: Page, count: int) -> None:
    """Waits until the table has as many rows as it shows in the end."""
    page.wait_for_function(f"() => document.querySelectorAll('{SHOWN}').length === {count}")


def chooser(page: Page, label: str) -> Locator:
    """The list of the values of a filter."""
    return page.locator(f".tools > label:has-text('{label}') select")


def test_a_click_sorts_with_the_best_first_and_another_reverses(visit: Visit) -> None:
    page = visit(ALL_ROWS)
    best = names(page)
    page.get_by_role("button", name="Sort by Kept").click()
    assert names(page)[0] == best[0] == f"{MANY}51"
    assert page.locator("th[data-key=final_performance]").get_attribute("aria-sort") == "descending"
    page.get_by_role("button", name="Sort by Kept").click()
    assert page.locator("th[data-key=final_performance]").get_attribute("aria-sort") == "ascending"
    assert names(page)[0] == f"{MANY}00"
    page.get_by_role("button", name="Reset").click()
    assert page.locator("th[aria-sort]").count() == 0


def test_a_search_finds_titles_folders_and_algorithms(visit: Visit) -> None:
    page = visit(ALL_ROWS)
    page.get_by_label("Search", exact=True).fill(f"{MANY}07")
    assert names(page) == [f"{MANY}07"]
    assert page.get_by_role("status").inner_text() == "1 of 53 submissions"
    page.get_by_label("Search", exact=True).fill("no such submission")
    assert names(page) == []
    page.get_by_label("Search", exact=True).fill("")
    assert page.get_by_role("status").inner_text() == "53 submissions; the first 50 are below"


def test_a_long_table_shows_fifty_rows_until_all_are_wanted(visit: Visit) -> None:
    page = visit(ALL_ROWS)
    first = names(page)
    assert len(first) == 50
    page.get_by_role("button", name="Show all 53 rows").click()
    wait_for_rows(page, 53)
    assert names(page)[:50] == first
    assert page.get_by_role("status").inner_text() == "53 submissions"
    assert page.get_by_role("button", name="Show all").count() == 0
    page.reload()
    wait_for_rows(page, 53)


def test_of_a_long_table_the_next_frame_has_fifty_rows_and_later_ones_the_others(visit: Visit) -> None:
    page = visit(f"{ALL_ROWS}#?all=1")
    wait_for_rows(page, 53)
    rows = f"document.querySelectorAll('{SHOWN}').length"
    drawn = page.evaluate(
        "() => new Promise((done) => { document.querySelector('[data-key=forgetting] .sort').click();"
        f"requestAnimationFrame(() => done({rows})); }})"
    )
    assert drawn == 50
    wait_for_rows(page, 53)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.get_by_label("Search", exact=True).fill(MANY)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert len(names(page)) == 52, "on paper all of them are there"


def test_filters_hide_the_other_submissions(visit: Visit) -> None:
    page = visit(BOARD)
    chooser(page, "Algorithm").select_option("keeper")
    assert names(page) == ["keeper"]
    chooser(page, "Algorithm").select_option("any")
    chooser(page, "Runs").select_option("at least 5")
    assert names(page) == ["agile"]


def test_two_ticked_submissions_are_compared_and_the_address_names_them(visit: Visit) -> None:
    page = visit(BOARD)
    assert page.get_by_role("button", name="Compare two").is_disabled()
    page.get_by_label("Compare Agile").check()
    page.get_by_label("Compare Keeper").check()
    page.get_by_role("button", name="Compare two").click()
    page.wait_for_url("**/compare.html#?first=agile&second=keeper")
    line = page.locator("#differences tr", has_text="hopper-gravity")
    line.locator(".interval").wait_for(state="attached")
    assert page.get_by_label("First").input_value() == "agile"
    difference = line.locator(".value").first.inner_text()
    page.get_by_label("First").select_option("keeper")
    page.get_by_label("Second").select_option("agile")
    page.wait_for_function("() => location.hash === '#?first=keeper&second=agile'")
    opposite = line.locator(".value").first.inner_text()
    assert opposite in {f"\N{MINUS SIGN}{difference}", difference.removeprefix("\N{MINUS SIGN}")}


def test_the_answer_over_the_core_comes_first(visit: Visit) -> None:
    page = visit("compare.html")
    first, second = page.locator("#compared .answers p").all_inner_texts()
    assert " keeps more than W" in first
    assert ", a significant difference (preliminary) in final performance: " in first
    assert second.startswith("Keeps forgets less than W")
    assert page.locator("#differences tbody tr").count() == 8
    page.get_by_label("Second").select_option("agile")
    page.evaluate("location.hash = 'main'")
    assert page.get_by_label("Second").input_value() == "agile", "a link within the page keeps the pair"
    assert page.locator("#compared").inner_text().split("share")[0].startswith("Keeps and Agile")
    page.get_by_label("Second").select_option("keeps")
    assert page.locator("#compared").inner_text() == "Choose two different submissions."
    page = visit("compare.html#?first=nobody&second=keeps")
    page.reload()
    assert "no submission “nobody”" in page.locator("#compared .note").inner_text()
    assert page.locator("#first").input_value() != page.locator("#second").input_value() == "keeps"


def test_compare_says_that_differences_are_not_loaded(page: Page, http_address: str) -> None:
    page.route("**/*.pairs.js", lambda route: route.abort())
    page.goto(f"{http_address}compare.html#?first=agile&second=keeper")
    page.locator("#compared .note").wait_for()
    assert "could not be loaded: hopper-gravity" in page.locator("#compared .note").inner_text()
    line = page.locator("#differences tr", has_text="hopper-gravity")
    assert line.locator(".value").all_inner_texts() == ["…", "…"]


def shown_panels(page: Page) -> list[str | None]:
    """The boards of a group that are shown."""
    return [panel.get_attribute("id") for panel in page.locator(".tabbed > section:visible").all()]


def test_tabs_show_one_board_at_a_time_without_script_and_by_keyboard(page: Page, address: str) -> None:
    context = page.context.browser.new_context(java_script_enabled=False) if page.context.browser else None
    assert context
    plain = context.new_page()
    plain.goto(address + GROUP)
    (first,) = shown_panels(plain)
    assert plain.locator(f"#{first} tbody tr[data-submission]").count() == 3
    plain.locator(".tabs a", has_text="Tasks").press("Enter")
    assert shown_panels(plain) == ["tasks"]
    plain.go_back()
    assert shown_panels(plain) == [first]
    plain.goto(address + "compare.html")
    assert not plain.locator("#compare").is_visible()
    assert plain.locator("main a[href='groups.html']").is_visible()
    context.close()


def test_the_address_holds_the_state_and_brings_it_back(visit: Visit) -> None:
    page = visit(f"{ALL_ROWS}#?q={MANY}0&sort=forgetting&up=1&hide=memory")
    assert len(names(page)) == 10
    assert page.get_by_label("Search", exact=True).input_value() == f"{MANY}0"
    assert page.locator("th[data-key=forgetting]").get_attribute("aria-sort") == "ascending"
    assert not page.locator("th[data-key=memory]").is_visible()
    order = names(page)
    page.get_by_label("Search", exact=True).fill(f"{MANY}01")
    assert "q=many-01&" in page.evaluate("location.href")
    page.get_by_label("Search", exact=True).fill(f"{MANY}0")
    assert "q=many-0&" in page.evaluate("location.href")  # after this answer, the browser knows it, too
    page.reload()
    assert names(page) == order


def test_what_the_address_names_and_the_table_has_not_is_said(visit: Visit) -> None:
    page = visit(f"{BOARD}#?sort=forgotten&hide=memory,cost&algorithm=agile&level=gold&runs=7&compare=nobody")
    said = page.get_by_role("status").inner_text()
    assert said.endswith("This table has no forgotten, cost, gold, 7, nobody.")
    page.get_by_role("button", name="Reset").click()
    assert "has no" not in page.get_by_role("status").inner_text()


def test_the_download_has_what_is_shown(visit: Visit) -> None:
    page = visit(f"{ALL_ROWS}#?q={MANY}1&hide=memory")
    with page.expect_download() as download:
        page.get_by_role("button", name="CSV").click()
    head, *rows = csv.reader(Path(download.value.path()).read_text("utf-8-sig").splitlines())
    assert [name for row in rows if (name := row[0].split()[-1]).startswith(MANY)] == names(page)
    assert "Kept" in head
    assert "Batch or buffer" not in head
    assert download.value.suggested_filename.endswith(".csv")


SCROLL = """(region) => {
  region.scrollIntoView();
  if (region.scrollHeight > region.clientHeight + 1) region.scrollTop = region.scrollHeight;
  else scrollBy({ top: region.clientHeight / 2, behavior: "instant" });
}"""


@pytest.mark.parametrize("width", [1200, 1500])
def test_the_head_stays_visible_while_the_rows_scroll(visit: Visit, width: int) -> None:
    page = visit(ALL_ROWS)
    page.emulate_media(reduced_motion="reduce")
    page.set_viewport_size({"width": width, "height": 400})
    page.locator(".wide").evaluate(SCROLL)
    head = page.locator(".wide thead th").first.bounding_box()
    first = page.locator(".wide tbody tr").first.bounding_box()
    assert head
    assert first
    assert first["y"] < head["y"] + head["height"], "the rows did not scroll"
    assert -1 <= head["y"] < 100
