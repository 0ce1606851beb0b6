"""A number opens a dialog with what is behind it; from there it takes one click to the results."""

import pytest

from .made_site import PAGES, Visit
from .test_layout import SERIOUS, axe

NUMBERS = {
    "overview": "tr[data-name=keeps] td.cell a.n",
    "board": "#row-agile a.n",
    "group": "tr[data-submission=keeps] a.n",
    "submission": "tr[data-number] a.n",
}


@pytest.mark.parametrize("kind", NUMBERS)
def test_a_number_opens_by_keyboard_and_gives_the_focus_back(visit: Visit, kind: str) -> None:
    page = visit(PAGES[kind])
    page.locator(NUMBERS[kind]).first.press("Enter")
    dialog = page.get_by_role("dialog")
    dialog.wait_for()
    assert "gym-extensions score submissions/" in dialog.inner_text()
    assert dialog.locator(".chosen").count() == 1
    page.evaluate(axe())
    assert page.evaluate(SERIOUS, ["#none", {}]) == []
    page.keyboard.press("Escape")
    assert not dialog.is_visible()
    assert page.evaluate("document.activeElement.matches('a.n')")


def test_two_clicks_lead_from_a_number_to_its_results(visit: Visit) -> None:
    page = visit(PAGES["overview"])
    page.locator(NUMBERS["overview"]).first.click()
    page.get_by_role("dialog").get_by_role("link", name="returns and files").first.click()
    page.wait_for_url("**/submissions/keeps/hopper-gravity-v0.html#hopper-gravity-v0-sequential")


def test_a_number_without_a_script_of_its_own_is_a_link(visit: Visit) -> None:
    page = visit(PAGES["group"])
    page.evaluate(
        "() => document.querySelectorAll('[data-number]').forEach((row) => { row.dataset.number = 'x.js'; })"
    )
    page.locator(NUMBERS["group"]).first.click()
    page.wait_for_url("**/submissions/keeps/hopper-gravity-v0.html#hopper-gravity-v0-sequential")
