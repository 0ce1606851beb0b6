"""The table of methods on the first page: cells, groups, sorting, Compare, and the address that has them."""

import re

from .made_site import Page, Visit

ROWS = "#core-table tr[data-name]"


def names(page: Page) -> list[str]:
    """The methods from top to bottom."""
    found: list[str] = page.locator(ROWS).evaluate_all("(rows) => rows.map((row) => row.dataset.name)")
    return found


def cell(page: Page, name: str, group: int = 0) -> str:
    """What the cell of a method and group shows."""
    return page.locator(f"tr[data-name={name}] .cell").nth(group).inner_text()


def test_the_table_is_whole_on_every_screen(visit: Visit) -> None:
    page, cut = visit("index.html"), []
    region = page.get_by_role("region", name="Table of methods")
    for width in (390, 700, 1119, 1120, 1200, 1280, 1327, 1328, 1366, 1400):
        page.set_viewport_size({"width": width, "height": 900})
        table, visible = region.evaluate("(region) => [region.scrollWidth, region.clientWidth]")
        cut += [width] if table > visible else []
    assert cut == []


def test_heads_sort_and_rows_without_a_value_are_last(visit: Visit) -> None:
    page = visit("index.html")
    assert names(page) == ["keeps", "loses", "lacks"]
    page.get_by_role("button", name="Kept", exact=True).click()
    page.get_by_role("button", name="Kept", exact=True).click()
    assert names(page) == ["loses", "keeps", "lacks"]
    assert page.locator("th[data-key=kept]").get_attribute("aria-sort") == "ascending"
    page.get_by_role("button", name="Method", exact=True).click()
    assert names(page) == ["keeps", "lacks", "loses"], "the title of the last one begins with W"
    assert page.locator("th[data-key=name]").get_attribute("aria-sort") == "ascending"
    described = page.get_by_role("button", name="Rank").get_attribute("aria-describedby")
    assert "First and last possible place" in (page.locator(f"#{described}").text_content() or "")


def test_cells_show_another_metric_and_the_address_keeps_it(visit: Visit) -> None:
    page = visit("index.html")
    kept = cell(page, "loses")
    page.get_by_role("radio", name="Forgotten").check()
    lost = cell(page, "loses")
    assert lost != kept
    page.reload()
    assert cell(page, "loses") == lost
    assert "no test" in page.locator(".status").first.inner_text()
    page.get_by_role("radio", name="Kept").check()
    assert cell(page, "loses") == kept


def test_an_order_by_some_groups_is_not_tested_and_has_no_rank(visit: Visit) -> None:
    page = visit("index.html#?groups=hopper-gravity,nowhere")
    assert names(page) == ["lacks", "keeps", "loses"], "the one that lacks other groups is best on this one"
    said = page.locator(".status").first.inner_text()
    assert said.startswith("This table has no nowhere. Kept is the mean over 1 of 7 groups, not tested;")
    assert said.endswith("drawings and other columns are over all.")
    assert page.locator(f"{ROWS} .place").first.inner_text().strip() == "–"
    page.get_by_text("Choose groups").click()
    for box in page.locator(".columns input").all():
        box.check()
    assert names(page) == ["keeps", "loses", "lacks"]
    assert page.evaluate("location.hash") in ("", "#")


def test_an_address_that_cannot_be_decoded_is_no_error(page: Page, address: str) -> None:
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{address}index.html#%E0%A4%A")
    assert names(page) == ["keeps", "loses", "lacks"]
    assert errors == []


def test_two_to_four_ticked_methods_open_compare(visit: Visit) -> None:
    page = visit("index.html")
    assert page.get_by_role("button", name="Tick two to four").is_disabled()
    for name in ("Keeps", "Lacks", "W"):
        page.get_by_label(f"Compare {name}").check()
    page.get_by_role("button", name="Compare 3").click()
    page.wait_for_url("**/compare.html#?first=keeps&second=lacks&third=loses")
    assert page.locator("#differences table").count() == 2
    page.get_by_label("Fourth").select_option("agile")
    page.wait_for_function("() => location.hash.endsWith('&fourth=agile')")


def test_a_cell_without_a_value_of_the_chosen_metric_does_not_show_the_score(
    page: Page, http_address: str
) -> None:
    text = page.request.get(f"{http_address}index.html").text()
    kept, others = text.partition('data-name="loses" data-cells="')[2].partition('"')[0].split(";", 1)
    text = text.replace(f"{kept};{others}", f"{kept};{re.sub('[^ ;]+', '-', others)}")
    page.route("**/index.html", lambda route: route.fulfill(body=text, content_type="text/html"))
    page.goto(f"{http_address}index.html")
    assert cell(page, "loses") != "–"
    page.get_by_role("radio", name="Transfer").check()
    assert cell(page, "loses") == "–"
