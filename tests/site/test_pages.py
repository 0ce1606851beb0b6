"""The content of the pages: problems, unsolved tasks, missing values, published tables, suites."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.scoring.references import load_references
from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED
from gym_extensions.site.page import pages
from gym_extensions.site.views import overview

from .browser import files, read

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


def test_every_page_with_scores_says_that_references_are_provisional(document: dict[str, Any]) -> None:
    paths = ("index.html", BOARD, "groups/hopper-gravity-v0.html", "submissions/agile.html")
    for path in paths:
        assert "rovisional references" in read(document)[path].text
    document["references"]["provisional"] = False
    for path in paths:
        assert "rovisional references" not in read(document)[path].text


def test_an_unsolved_task_is_named_and_has_raw_returns(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    scores["reference"]["gym_extensions/Hopper-v0"] = {"floor": 0.0, "ceiling": None, "unsolved": True}
    page = read(document)["submissions/agile.html"]
    assert "Not scored (unsolved): Hopper. No reference agent has learned this task" in page.text
    assert "raw return (unsolved)" in page.text
    assert any(
        attributes.get("class", "").startswith("unsolved") for tag, attributes in page.elements if tag == "td"
    )


def test_a_group_without_references_has_raw_returns(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    for task in scores["tasks"]:
        scores["reference"][task] = {"floor": None, "ceiling": None, "unsolved": None}
    for name in scores["metrics"]:
        scores["metrics"][name] = {
            "mean": None,
            "low": None,
            "high": None,
            "runs": [],
            "why": "There is no reference.",
        }
    page = read(document)["submissions/agile.html"]
    assert "No metrics. There is no reference." in page.text
    assert "900" in page.text


def test_a_published_table_shows_what_it_has_and_lists_what_is_missing(document: dict[str, Any]) -> None:
    table = document["submissions"][1]
    table.update(trust="reported", groups={"hopper-gravity-v0": table["groups"]["hopper-gravity-v0"]})
    scores = table["groups"]["hopper-gravity-v0"]["sequential"]
    null: dict[str, Any] = {"mean": None, "low": None, "high": None, "runs": [], "why": "Reported: no floor."}
    scores.update(
        budget="paper",
        runs=[],
        return_matrix=[],
        metrics=dict.fromkeys(scores["metrics"], null),
        missing_for_full_entry=["logs", "5 runs"],
        printed_total={**scores["paper_total"], "fully_trained": {"mean": 990.95, "std": 1022.32}},
        notes=["The printed total is not the mean of its rows."],
    )
    pages = read(document)
    text = pages["submissions/keeper.html"].text
    for sentence in (
        "Missing: logs, 5 runs.",
        "No metrics. Reported: no floor.",
        "Group, as printed 990.95 ± 1022.32",
        "The printed total is not the mean of its rows.",
    ):
        assert sentence in text
    assert "Evaluation matrix" not in text
    assert "Reported elsewhere" in pages["entries.html"].text
    assert "boards/hopper-gravity-v0-sequential-paper.html" not in pages


def test_a_suite_is_on_a_board_before_its_groups_and_on_the_page_of_the_entry(
    document: dict[str, Any],
) -> None:
    card = document["submissions"][0]
    scores = card["groups"]["hopper-gravity-v0"]["sequential"]
    bodies = ("hopper", "walker2d", "halfcheetah", "humanoid")
    card["groups"] = {f"{body}-gravity-v0": {"sequential": scores} for body in bodies}
    metrics = {name: {**value, "runs": []} for name, value in scores["metrics"].items()}
    card["suites"] = {
        "gravity": {"sequential": {"budget": "100k", "groups": list(card["groups"]), "metrics": metrics}}
    }
    pages = read(document)
    first = next(
        a["href"] for tag, a in pages["index.html"].elements if a.get("href", "").startswith("boards/")
    )
    assert first == "boards/gravity-sequential-100k.html"
    for path in ("index.html", "groups.html", "groups/gravity.html", first):
        assert "gravity suite, mean of 4 groups" in pages[path].text
    assert "gravity suite, mean of 4 groups" in pages["submissions/agile.html"].text


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


def test_an_entry_on_several_groups_has_a_page_of_results_per_group(document: dict[str, Any]) -> None:
    built = read(document)
    paths = [f"submissions/keeper/{body}-gravity-v0.html" for body in ("hopper", "walker2d")]
    links = {a.get("href", "") for _, a in built["submissions/keeper.html"].elements}
    for path in paths:
        assert "Evaluation matrix" in built[path].text
        assert path.removeprefix("submissions/") in {link.removeprefix("../submissions/") for link in links}
    assert "Evaluation matrix" not in built["submissions/keeper.html"].text
    assert "Evaluation matrix" in built["submissions/agile.html"].text
    assert not [path for path in built if path.startswith("submissions/agile/")]


def test_a_group_page_spells_out_what_one_means(document: dict[str, Any]) -> None:
    current = load_references()
    document["references"] = {"version": current.version, "provisional": False, "sha256": current.digest}
    text = read(document)["groups/halfcheetah-gravity-v0.html"].text
    assert re.search(
        r"1 = [\w-]+, \w+ steps, five runs: returns \d+, \d+, \d+, \d+, \d+; mean \d+\. 0 = ", text
    )
    document["references"]["sha256"] = "00" * 32
    text = read(document)["groups/halfcheetah-gravity-v0.html"].text
    assert "No reference has been measured." in text
    assert "measured.." not in text


def test_the_one_of_a_task_of_navigation_is_the_oracle(document: dict[str, Any]) -> None:
    current = load_references()
    document["references"] = {"version": current.version, "provisional": False, "sha256": current.digest}
    text = read(document)["groups/nav-state-v0.html"].text
    assert re.search(r"1 = oracle: return −\d+\. 0 = the zero action: return −1000\.", text)


def test_a_group_page_has_the_numbers_of_a_publication_beside_those_of_the_first_entries(
    document: dict[str, Any],
) -> None:
    printed = copy.deepcopy(document["submissions"][0])
    printed.update(name="printed", title="Printed", trust="reported")
    printed["groups"]["hopper-gravity-v0"].pop("single")
    document["submissions"].append(printed)
    page = read(document)["groups/hopper-gravity-v0.html"]
    assert "The paper’s four columns" in page.text
    assert "Gravity Half Printed printed" in page.text
    assert "Agile agile" in page.text.split("four columns")[1]
    assert "four columns" not in read(document)["groups/walker2d-gravity-v0.html"].text


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


def test_an_entry_that_is_first_on_most_of_too_many_boards_to_name_is_named_once(
    document: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(overview, "MAX_NAMED", 0)
    document["submissions"] = [card for card in document["submissions"] if card["name"] == "agile"]
    text = read(document)["index.html"].text
    assert "Best final performance: Agile (agile) leads on 1 of 1 board with a ranked entry. Least" in text


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
