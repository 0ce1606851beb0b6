"""Boards with many entries: pages of 50 rows, and tables of all rows that stay below a size."""

from __future__ import annotations

from typing import Any

import pytest

from gym_extensions.site import tables as board_page

from .browser import Pages, Reader, read
from .conftest import everything, learner, sequential, submission

FIRST = "boards/hopper-gravity-v0-sequential-100k"


def sixty() -> dict[str, Any]:
    """A document of sixty entries with one run and different scores."""
    scores = sequential("hopper-gravity", learner(0.9, 0.75, 1))
    final = scores["metrics"]["final_performance"]
    entries = []
    for number in range(60):
        metrics = {
            **scores["metrics"],
            "final_performance": {**final, "runs": [number / 100], "mean": number / 100},
        }
        groups = {"hopper-gravity-v0": {"sequential": {**scores, "metrics": metrics}}}
        entries.append(submission(f"e{number:02d}", groups, f"Entry {number}"))
    return {**everything(), "submissions": entries}


@pytest.fixture(scope="module")
def pages() -> Pages:
    """The pages of sixty entries."""
    return read(sixty())


def names(page: Reader) -> list[str]:
    """The entries of a page with drawings."""
    return [attributes["data-entry"] for _, attributes in page.elements if "data-entry" in attributes]


def is_interactive(page: Reader) -> bool:
    """Whether the script sorts and filters the page."""
    return any("data-table" in attributes for tag, attributes in page.elements if tag == "table")


def test_a_page_has_fifty_rows_in_the_order_of_the_board(pages: Pages) -> None:
    order = [f"e{number:02d}" for number in reversed(range(60))]
    assert names(pages[f"{FIRST}.html"]) == order[:50]
    assert names(pages[f"{FIRST}-2.html"]) == order[50:]
    assert "1 to 50 of 60" in pages[f"{FIRST}.html"].text
    assert "51 to 60 of 60" in pages[f"{FIRST}-2.html"].text


def test_only_the_table_of_all_rows_can_be_sorted(pages: Pages) -> None:
    paths = (f"{FIRST}.html", f"{FIRST}-2.html", f"{FIRST}-all.html")
    assert [is_interactive(pages[path]) for path in paths] == [False, False, True]
    assert sum(tag == "i" for tag, _ in pages[f"{FIRST}-all.html"].elements) == 60
    assert "sort, search, filter, compare" in pages[f"{FIRST}.html"].text


def test_pages_lead_to_each_other(pages: Pages) -> None:
    links = {a.get("rel"): a["href"] for tag, a in pages[f"{FIRST}.html"].elements if tag == "a"}
    assert links["next"] == f"../{FIRST}-2.html"
    back = {a.get("rel"): a["href"] for tag, a in pages[f"{FIRST}-2.html"].elements if tag == "a"}
    assert (back["prev"], "next" in back) == (f"../{FIRST}.html", False)


def test_a_table_of_all_rows_that_is_too_large_is_divided(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(board_page, "PAGE_BYTES", 6000)
    pages = read(sixty())
    parts = [path for path in pages if path.startswith(f"{FIRST}-all")]
    assert len(parts) == 3
    assert sum(tag == "i" for path in parts for tag, _ in pages[path].elements) == 60
    assert not any(is_interactive(pages[path]) for path in parts)
    assert "Rows 1 to 29 of 60" in pages[f"{FIRST}-all.html"].text


def test_a_board_of_fifty_entries_has_one_page(document: dict[str, Any]) -> None:
    pages = read(document)
    assert is_interactive(pages[f"{FIRST}.html"])
    assert [path for path in pages if path.startswith(f"{FIRST}-") and "conditioned" not in path] == []
