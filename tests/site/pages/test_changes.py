"""What changed: decisions and verifications, newest first, as a page and as an Atom feed."""

import re
from typing import Any
from xml.etree import ElementTree

from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.changes import MOST, changes, records

from ..browser import files, references_of, typed
from .test_core import GROUPS, LABELLED, method, trained_here

ATOM = "{http://www.w3.org/2005/Atom}"
PART = {
    "date": "2026-11-24", "version": "1.0.0", "value": "0f", "logs": ["hopper-gravity/single"], "runs": 5,
    "current": 5, "episodes": 600, "repeated": 600, "difference": "", "cells": 5,
    "p_value": 0.5, "second_p_value": None, "passed": True, "retrained": [],
}  # fmt: skip
ACCEPTED = {"action": "accepted", "by": "M.", "date": "2026-11-25", "reason": "<All> of it."}


def test_a_day_has_one_row_per_submission_and_kind_and_the_newest_comes_first(
    document: dict[str, Any],
) -> None:
    document["submissions"][0] |= {"decisions": [ACCEPTED], "verifications": [PART, {**PART, "runs": 2}]}
    slow = {**PART, "passed": False, "episodes": 0, "undecided": "undecided: too slow"}
    document["submissions"][1] |= {"verifications": [{**PART, "passed": False}, slow]}
    whole = typed(document)
    found = changes(Leaderboard(references_of(whole), whole.submissions))
    assert [(row.date, row.name, row.kind) for row in found] == [
        ("2026-11-25", "agile", "accepted"),
        ("2026-11-24", "keeper", "undecided"),
        ("2026-11-24", "keeper", "not verified"),
        ("2026-11-24", "agile", "verified"),
    ]
    assert found[3].text.replace("\N{NARROW NO-BREAK SPACE}", "") == "7 runs, 1200 of 1200 episodes repeated."
    written = dict(files(document))
    feed = ElementTree.fromstring(written["feed.xml"])
    entries = feed.findall(f"{ATOM}entry")
    assert entries[0].find(f"{ATOM}link").get("href") == "submissions/agile.html"  # type: ignore[union-attr]
    assert entries[0].findtext(f"{ATOM}summary") == "<All> of it."
    assert feed.findtext(f"{ATOM}updated") == "2026-11-25T00:00:00Z"
    assert len({entry.findtext(f"{ATOM}id") for entry in entries}) == 4
    assert "Accepted: &lt;All&gt; of it." in written["changes.html"]


def test_the_page_has_all_changes_the_feed_the_newest_and_a_reason_that_is_cut_a_link(
    document: dict[str, Any],
) -> None:
    days = [f"20{year}-11-24" for year in range(10, 10 + MOST + 1)]
    verified, accepted = [{**PART, "date": day} for day in days], {**ACCEPTED, "reason": "long " * 50}
    document["submissions"][0] |= {"decisions": [accepted], "verifications": verified}
    written = dict(files(document))
    assert all(f'id="{day}-agile-verified"' in written["changes.html"] for day in days)
    assert len(ElementTree.fromstring(written["feed.xml"]).findall(f"{ATOM}entry")) == MOST
    assert written["changes.html"].count('href="submissions/agile.html#decisions"') == 1
    assert 'id="decisions"' in written["submissions/agile.html"]


def test_a_site_without_reviews_has_an_empty_feed(document: dict[str, Any]) -> None:
    written = dict(files(document))
    assert ElementTree.fromstring(written["feed.xml"]).findall(f"{ATOM}entry") == []
    assert "No submission has been accepted" in written["changes.html"]


def verified(card: dict[str, Any], date: str, groups: list[str]) -> dict[str, Any]:
    """The submission with one more verification, of groups of the core."""
    part = {**PART, "date": date, "logs": [f"{each}/sequential" for each in groups]}
    return {**card, "verifications": [*card.get("verifications", ()), part]}


def test_the_best_core_score_has_a_step_where_a_method_is_above_all_that_came_before(
    document: dict[str, Any],
) -> None:
    first = verified(method("first", 0.8, 0.5), "2026-11-20", GROUPS)
    lower = verified(method("lower", 0.7, 0.5), "2026-11-21", GROUPS)
    part = verified(method("higher", 0.8, 0.9), "2026-11-19", GROUPS[1:])
    whole = verified(part, "2026-11-22", GROUPS)
    document["submissions"] = [first, lower, part, verified(LABELLED, "2026-11-20", GROUPS)]
    assert "So far all came on one day." in dict(files(document))["changes.html"], "one group is not verified"
    document["submissions"][2] = whole
    cards = typed(document)
    found = records(Leaderboard(references_of(cards), cards.submissions))
    steps = {key: [(day, row.name) for day, row in each] for key, each in found.items()}
    assert steps == {
        "Without task label": [("2026-11-20", "first"), ("2026-11-22", "higher")],
        "With the task label at test time": [("2026-11-20", "labelled")],
    }
    page = dict(files(document))["changes.html"]
    assert re.search(r"Without task label: 0\.\d\d since 2026-11-22; With", page)
    assert '<path class="line p2"' in page


def test_a_method_that_was_trained_here_counts_from_the_day_on_which_its_runs_were_finished(
    document: dict[str, Any],
) -> None:
    card = trained_here("new")
    card["training"]["finished"] = "2026-01-05"
    document["submissions"] = [card]
    cards = typed(document)
    found = changes(Leaderboard(references_of(cards), cards.submissions))
    assert [(row.date, row.kind) for row in found] == [
        ("2026-01-05", "trained here"),
        ("2026-01-05", "highest core score"),
    ]
    card["training"]["finished"] = ""
    cards = typed(document)
    assert changes(Leaderboard(references_of(cards), cards.submissions)) == []
