"""Pages of entries and boards: missing values, problems, leaders, copies and curves."""

from __future__ import annotations

import copy
import re
from typing import Any

import pytest

from ..browser import files, read

BOARD = "boards/hopper-gravity-v0-sequential-100k.html"


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
