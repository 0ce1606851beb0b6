"""The overview and the pages that explain: metrics, trust, references and the menu."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED
from gym_extensions.site.page import pages
from gym_extensions.site.views import overview
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.board_row import Row

from ..browser import files, read

BOARD = "boards/hopper-gravity-v0-sequential-100k.html"


def test_every_page_with_scores_says_that_references_are_provisional(document: dict[str, Any]) -> None:
    paths = ("index.html", BOARD, "groups/hopper-gravity-v0.html", "submissions/agile.html")
    for path in paths:
        assert "rovisional references" in read(document)[path].text
    document["references"]["provisional"] = False
    for path in paths:
        assert "rovisional references" not in read(document)[path].text


def test_the_metrics_page_has_every_formula_of_the_scorer() -> None:
    from gym_extensions.scoring.metrics.definitions import METRICS

    page = read(
        {"format": 1, "references": {"version": "x", "provisional": False, "sha256": ""}, "submissions": []}
    )
    text = page["metrics.html"].text
    for metric in (metric for protocol in METRICS.values() for metric in protocol):
        assert re.sub(r"\s+", " ", metric.formula) in text
        assert metric.name in page["metrics.html"].ids


def test_the_meaning_of_replayed_names_the_limits_of_the_sample(document: dict[str, Any]) -> None:
    text = read(document)["metrics.html"].text
    assert "replayed A sample of the episodes" in text
    assert "a determined cheat could edit the log until the drawn part misses the edit" in text
    assert "does not show how often a policy was trained" in text


def test_the_levels_of_trust_of_the_scorer_are_explained(document: dict[str, Any]) -> None:
    page = dict(files(document))["metrics.html"]
    named = re.findall(r'class="trust trust-([a-z-]+)">([a-z, -]+)<', page)
    assert named == [
        (REPORTED, "reported"),
        (VALIDATED, "checked, not replayed"),
        ("replayed", "replayed"),
        ("re-evaluated", "re-evaluated"),
        ("reproduced", "reproduced"),
        ("refused", "refused"),
    ]


def test_boards_without_a_score_are_in_one_line_with_the_reason(document: dict[str, Any]) -> None:
    null: dict[str, Any] = {"mean": None, "low": None, "high": None, "runs": [], "why": "All unsolved."}
    scores = document["submissions"][1]["groups"]["walker2d-gravity-v0"]["sequential"]
    scores["metrics"] = dict.fromkeys(scores["metrics"], null)
    page = dict(files(document))["index.html"]
    folded = page.split("<details")[1].split("</details>")[0]
    assert "No score yet: 1 board" in folded
    assert "All unsolved." in folded
    assert "walker2d-gravity-v0" not in page.split("<details")[0]


def test_the_overview_says_who_ends_best_and_who_forgets_least(document: dict[str, Any]) -> None:
    text = read(document)["index.html"].text
    assert re.search(
        r"Best final performance: Agile \(agile\) with 0\.55 \(0\.48 to 0\.61\) on hopper-gravity-v0, 100k; "
        r"Oracle \(oracle\) with .* on hopper-gravity-v0, 100k, task label\. "
        r"Least forgetting among those that learned: Agile \(agile\) with "
        r"0\.44 \(0\.39 to 0\.49\) on hopper-gravity-v0, 100k; ",
        text,
    )


def test_boards_of_a_single_ranked_entry_are_left_out_where_others_have_several(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Board, "ranked", property(lambda board: 2 if board.task_conditioned else 1))
    text = read(document)["index.html"].text
    assert "Best final performance: Oracle (oracle) with" in text
    assert "Agile (agile) with" not in text
    monkeypatch.setattr(overview, "MAX_NAMED", 0)
    text = read(document)["index.html"].text
    assert "Oracle (oracle) leads on 1 of 1 board with several ranked entries" in text


def test_an_entry_that_is_first_on_most_of_too_many_boards_to_name_is_named_once(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(overview, "MAX_NAMED", 0)
    document["submissions"] = [card for card in document["submissions"] if card["name"] == "agile"]
    text = read(document)["index.html"].text
    assert "Best final performance: Agile (agile) leads on 1 of 1 board with a ranked entry. Least" in text


def test_an_entry_that_is_first_in_a_tie_is_said_to_be(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(overview, "MAX_NAMED", 0)
    monkeypatch.setattr(Row, "tied", lambda *_: 2)
    document["submissions"] = [card for card in document["submissions"] if card["name"] == "agile"]
    text = read(document)["index.html"].text
    assert "leads on 1 of 1 board with a ranked entry, 1 of them in a tie. Least" in text


def test_the_metrics_page_says_which_comparison_is_which(document: dict[str, Any]) -> None:
    text = read(document)["metrics.html"].text
    assert "Tied with N others" in text
    assert "Level with the first" in text
    assert "M − 1" in text


def test_speed_is_linked_in_the_footer_and_not_in_the_menu(document: dict[str, Any]) -> None:
    menu, footer = (
        re.search(rf"<{tag}.*?</{tag}>", dict(files(document))["index.html"], re.DOTALL)
        for tag in ("nav", "footer")
    )
    assert menu
    assert footer
    assert ("speed.html" in menu[0], "speed.html" in footer[0]) == (False, True)


def test_every_module_in_the_folder_is_a_page_in_the_order_of_the_menu(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    import gym_extensions.site.pages as folder

    titles = [page.title for page in pages()]
    assert titles == [
        *("Overview", "Groups", "Boards", "Tasks", "Submissions", "Entries", "Compare", "Metrics", "Submit"),
        *("References", "Data", "Changes", "About", "Speed", "Pictures", "Exports"),
    ]
    module = (
        "from gym_extensions.site.page import Page\nPAGE = Page('Extra', 7, lambda site, render: iter(()))\n"
    )
    (tmp_path / "extra.py").write_text(module, encoding="utf-8")
    monkeypatch.setattr(folder, "__path__", [*folder.__path__, str(tmp_path)])
    assert [page.title for page in pages()] == [*titles[:3], "Extra", *titles[3:]]
