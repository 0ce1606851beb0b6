"""Boards with many entries: the first rows with drawings, all of them in pages of a lean table."""

from __future__ import annotations

from typing import Any

import pytest

from gym_extensions.site import pages as site_pages

from .browser import Pages, read
from .conftest import everything, learner, sequential, submission

BOARD = "boards/hopper-gravity-v0-sequential-100k"


def thirty() -> dict[str, Any]:
    """A document of thirty entries with one run and different scores."""
    scores = sequential("hopper-gravity", learner(0.9, 0.75, 1))
    final = scores["metrics"]["final_performance"]
    entries = []
    for number in range(30):
        value = {**final, "runs": [number / 100], "mean": number / 100}
        metrics = {**scores["metrics"], "final_performance": value}
        groups = {"hopper-gravity-v0": {"sequential": {**scores, "metrics": metrics}}}
        entries.append(submission(f"e{number:02d}", groups, f"Entry {number}"))
    return {**everything(), "submissions": entries}


def listed(pages: Pages, path: str) -> int:
    """The number of rows of a lean table."""
    return sum(tag == "i" for tag, _ in pages[path].elements)


def test_a_group_draws_twenty_rows_and_its_board_lists_all() -> None:
    pages = read(thirty())
    group = pages["groups/hopper-gravity-v0.html"]
    drawn = [attributes["data-entry"] for _, attributes in group.elements if "data-entry" in attributes]
    assert drawn == [f"e{number}" for number in range(29, 9, -1)]
    assert "the first 20 of 30" in group.text
    assert "All 30 entries: sort, search, filter, compare" in group.text
    assert listed(pages, f"{BOARD}.html") == 30
    assert any("data-table" in a for tag, a in pages[f"{BOARD}.html"].elements if tag == "table")


def test_a_long_table_has_pages_that_lead_to_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(site_pages, "PAGE_ROWS", 12)
    pages = read(thirty())
    paths = [f"{BOARD}{part}.html" for part in ("", "-2", "-3")]
    assert [listed(pages, path) for path in paths] == [12, 12, 6]
    links = {a.get("rel"): a["href"] for tag, a in pages[paths[1]].elements if tag == "a"}
    assert (links["prev"], links["next"]) == (f"../{paths[0]}", f"../{paths[2]}")
    assert not any("data-table" in a for tag, a in pages[paths[0]].elements if tag == "table")
