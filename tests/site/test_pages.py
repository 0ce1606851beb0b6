"""Pages of entries, the overview, and the pages that explain."""

from __future__ import annotations

import copy
import re
from typing import Any

import pytest

from gym_extensions.rollouts.review import LEVELS
from gym_extensions.site import groups as overview
from gym_extensions.site.boards import Board, Row

from .browser import files, read


def test_a_missing_value_has_a_reason_and_is_not_zero(document: dict[str, Any]) -> None:
    document["submissions"] = document["submissions"][:1]
    built = read(document)
    assert "there is no single.csv to pair with" in built[BOARD].text
    assert "there is no single.csv to pair with" in built["submissions/agile.html"].text
    row = dict(files(document))[BOARD].split('data-label="Asymptotic transfer"')[1].split("</td>")[0]
    assert "0.00" not in row
    assert 'class="none"' in row


def test_the_dash_of_a_missing_value_links_to_its_reason(document: dict[str, Any]) -> None:
    page = dict(files(document))[BOARD]
    cell = page.split('data-label="Asymptotic transfer"')[1].split("</td>")[0]
    (note,) = re.findall(r'– <a class="see" href="#([a-z0-9-]+)" title="[^"]+">note 1</a>', cell)
    assert f'<li id="{note}">there is no single.csv to pair with</li>' in page


def test_the_readme_of_a_submission_has_its_paragraphs_and_line_breaks(document: dict[str, Any]) -> None:
    document["submissions"][0]["readme"] = "\n# Agile & quick\n\n\tlearns\n  *fast*\n"
    page = dict(files(document))["submissions/agile.html"]
    assert '<pre class="readme"># Agile &amp; quick\n\n\tlearns\n  *fast*</pre>' in page
    assert 'href="#readme"' in page


@pytest.mark.parametrize("text", ["", " \n\t\n"])
def test_a_blank_readme_has_no_section(document: dict[str, Any], text: str) -> None:
    document["submissions"][0]["readme"] = text
    assert "readme" not in dict(files(document))["submissions/agile.html"]


def test_a_row_of_a_board_says_how_actions_are_selected(document: dict[str, Any]) -> None:
    document["submissions"][0]["manifest"]["protocol"]["evaluation"] = "deterministic"
    page = dict(files(document))[BOARD]
    cells = re.findall(r'<span class="tags">(\w+ \w+)<', page)
    assert set(cells) == {"deterministic actions", "sampled actions"}


def test_a_refused_submission_is_listed_with_its_problems_and_hints(document: dict[str, Any]) -> None:
    pages = read(document)
    text = pages["submissions/broken.html"].text
    assert "missing-cell hopper-gravity/sequential.csv, row 7" in text
    assert "Run 0, stage 2 has no episode of gym_extensions/Hopper-v0." in text
    assert "Evaluate every task after every stage." in text
    assert "Broken broken refused 1 problem: missing-cell" in pages["entries.html"].text
    assert "1 refused" in pages["index.html"].text


def test_the_leader_of_a_board_is_its_first_ranked_entry(document: dict[str, Any]) -> None:
    """The board does not call a ranked entry full, which means that no protocol is missing."""
    board = read(document)[BOARD].text
    assert "Agile agile leads the ranked entries with 0.55" in board
    assert "full entr" not in board


@pytest.mark.parametrize(
    ("code", "shown"),
    [
        ({"url": "https://example.org/agent", "commit": "abc1"}, "Code https://example.org/agent at abc1"),
        ({"url": "https://example.org/agent", "commit": ""}, "Code https://example.org/agent"),
        ({"url": "", "commit": "abc1"}, "Code commit abc1"),
    ],
)
def test_the_commit_of_the_code_is_shown_with_and_without_a_url(
    document: dict[str, Any], code: dict[str, str], shown: str
) -> None:
    document["submissions"][0]["manifest"]["code"] = code
    assert shown in read(document)["submissions/agile.html"].text
    document["submissions"][0]["manifest"]["code"] = {"url": "", "commit": ""}
    assert " Code " not in read(document)["submissions/agile.html"].text


def test_an_agent_that_learned_nothing_is_marked_next_to_its_forgetting(
    document: dict[str, Any],
) -> None:
    assert "nothing learned to forget" in read(document)["submissions/zero.html"].text
    assert "nothing learned to forget" not in read(document)["submissions/agile.html"].text


def test_training_curves_of_the_document_are_drawn(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    assert "Learning curves" not in read(document)["submissions/agile.html"].text
    points = [[2000 * step, 10.0 * step] for step in range(1, 11)]
    scores["curves"] = [{"run": 0, "task": "gym_extensions/Hopper-v0", "points": points}]
    page = read(document)["submissions/agile.html"]
    assert "Learning curves" in page.text
    assert "gym_extensions/Hopper-v0: training returns, at the end 100" in str(page.elements)


def test_a_copy_stands_below_the_other_entry_without_a_rank(document: dict[str, Any]) -> None:
    assert "Has most episodes" not in read(document)[BOARD].text
    for protocols in document["submissions"][0]["groups"].values():
        for scores in protocols.values():
            scores["episode_sketches"] = [["00c0ffee"]]
    copied = copy.deepcopy(document["submissions"][0])
    copied.update(name="copied", title="Something new")
    document["submissions"].insert(1, copied)
    board = dict(files(document))[BOARD]
    assert re.findall(r'data-entry="(\w+)"', board)[:2] == ["agile", "copied"]
    assert "Not ranked: Has most episodes of agile." in board


def test_a_budget_without_a_board_says_so(document: dict[str, Any]) -> None:
    budgets = read(document)["metrics.html"].text.split("Budgets")[-1]
    rows = re.findall(
        r"(paper|1M \(long\)|300k \(standard\)|100k \(quick\)|smoke \(tests\)) (.*?)\.", budgets
    )
    assert [(name, sentence.rpartition("; ")[2]) for name, sentence in rows] == [
        ("paper", "no board uses it yet"),
        ("1M (long)", "no board uses it yet"),
        ("300k (standard)", "no board uses it yet"),
        ("100k (quick)", "100 000 training steps per task"),
        ("smoke (tests)", "never on a board"),
    ]


BOARD = "boards/hopper-gravity-v0-sequential-100k.html"


def test_the_metrics_page_has_every_formula_of_the_scorer() -> None:
    from gym_extensions.scoring.metrics import METRICS

    page = read({"format": 1, "references": {"version": "x", "sha256": ""}, "submissions": []})
    text = page["metrics.html"].text
    for metric in (metric for protocol in METRICS.values() for metric in protocol):
        assert re.sub(r"\s+", " ", metric.formula) in text
        assert metric.name in page["metrics.html"].ids


def test_the_levels_are_explained_from_the_lowest(document: dict[str, Any]) -> None:
    page = dict(files(document))["metrics.html"]
    assert re.findall(r'class="badge badge-([a-z]+)">\1<', page) == list(LEVELS)


def test_boards_without_a_score_are_in_one_line_with_the_reason(document: dict[str, Any]) -> None:
    null: dict[str, Any] = {"mean": None, "low": None, "high": None, "runs": [], "why": "All open."}
    scores = document["submissions"][1]["groups"]["walker2d-gravity-v0"]["sequential"]
    scores["metrics"] = dict.fromkeys(scores["metrics"], null)
    page = dict(files(document))["index.html"]
    folded = page.split("<details")[1].split("</details>")[0]
    assert "No score yet: 1 board" in folded
    assert "All open." in folded
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
    assert "The same test, over all pairs" in text


def test_speed_is_linked_in_the_footer_and_not_in_the_menu(document: dict[str, Any]) -> None:
    menu, footer = (
        re.search(rf"<{tag}.*?</{tag}>", dict(files(document))["index.html"], re.DOTALL)
        for tag in ("nav", "footer")
    )
    assert menu
    assert footer
    assert ("speed.html" in menu[0], "speed.html" in footer[0]) == (False, True)


FOUND = {
    "date": "2026-11-24",
    "version": "1.0.0",
    "value": "ab" * 32,
    "logs": ["hopper-gravity/sequential"],
    "runs": 5,
    "current": 5,
    "episodes": 3000,
    "repeated": 2999,
    "difference": "run 1, stage 2, episode 7: 1e-12",
    "kernels": "openblas Haswell",
    "cells": 45,
    "p_value": 0.31,
    "second_p_value": None,
    "passed": True,
    "retrained": [],
}


def text_of(document: dict[str, Any], path: str = "submissions/agile.html") -> str:
    return read(document)[path].text


def test_an_entry_shows_what_its_verification_found(document: dict[str, Any]) -> None:
    document["submissions"][0]["verifications"] = [FOUND]
    text = text_of(document)
    for fact in ("2026-11-24", "2 999 of 3 000", "run 1, stage 2, episode 7: 1e-12", "0.310"):
        assert fact in text
    assert "gym-extensions verify submissions/agile" in text
    assert "changed since" not in text


def test_runs_that_changed_since_their_verification_are_counted(document: dict[str, Any]) -> None:
    document["submissions"][0]["verifications"] = [{**FOUND, "current": 3, "second_p_value": 0.0001}]
    text = text_of(document)
    assert "2 changed since" in text
    assert "second draw < 0.001" in text


@pytest.mark.parametrize("level", ["claimed", "verified", "reproduced"])
def test_the_level_of_an_entry_is_shown_and_verified_ones_are_counted(
    document: dict[str, Any], level: str
) -> None:
    for entry in document["submissions"]:
        entry["level"] = entry["level"] and "claimed"
        for protocols in entry["groups"].values():
            for scores in protocols.values():
                scores["level"] = "claimed"
    first = document["submissions"][0]
    first["level"] = first["groups"]["hopper-gravity-v0"]["sequential"]["level"] = level
    pages = read(document)
    assert f"agile {level}" in pages["submissions/agile.html"].text
    count = "0 are" if level == "claimed" else "1 is"
    assert f"of which {count} verified" in pages["index.html"].text


def test_decisions_are_shown_as_they_are_and_escaped(document: dict[str, Any]) -> None:
    decisions = [
        {"action": "accepted", "by": "one", "date": "2026-11-22", "reason": "Verified."},
        {"action": "challenged", "by": "two", "date": "2026-11-23", "reason": "<script>x</script> doubt"},
    ]
    document["submissions"][0]["decisions"] = decisions
    page = read(document)["submissions/agile.html"]
    assert "Challenged on 2026-11-23 by two: <script>x</script> doubt" in page.text
    assert page.errors == []
    assert "challenged" in text_of(document, BOARD)
    decisions.append({"action": "withdrawn", "by": "one", "date": "2026-11-24", "reason": "An error."})
    assert "withdrawn" in text_of(document, "entries.html")


def test_how_the_runs_were_made_is_a_folded_table(document: dict[str, Any]) -> None:
    made = {
        "run": 3,
        "command": "gym-extensions train trpo --runs 3",
        "commit": "0123456789abcdef",
        "by": "",
        "date": None,
        "versions": {"mujoco": "4.0.0", "python": "3.11.7", "blas": ""},
        "processor": "",
        "steps": 1_500_000,
        "cpu_seconds": 1234.5,
        "peak_memory_mb": None,
        "memory": {"stored_steps": 2000, "parameters_first": 10, "parameters_last": 10},
        "policies": True,
    }
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    scores.update(provenance=[made], why_claimed="Nobody has verified it.")
    page = dict(files(document))["submissions/agile.html"]
    table = page.split("How the runs were made</summary>")[1].split("</details>")[0]
    for fact in ("gym-extensions train trpo --runs 3", "0123456789<", "mujoco 4.0.0, python 3.11.7"):
        assert fact in table
    assert "1\u202f500\u202f000" in table
    assert "Nobody has verified it." in page


def test_signs_are_listed_without_a_verdict(document: dict[str, Any]) -> None:
    document["submissions"][0]["signs"] = ["Every return is a multiple of 10."]
    text = text_of(document)
    assert "Every return is a multiple of 10." in text
    assert "none of them is a verdict" in text


def test_related_entries_are_counted_on_the_row(document: dict[str, Any]) -> None:
    for entry in document["submissions"][:2]:
        entry["manifest"]["protocol"]["algorithm"] = "trpo"
    assert "1 related entry on this board" in text_of(
        document, "boards/hopper-gravity-v0-sequential-100k.html"
    )
