"""What the pages say: problems, open tasks, what is missing, published tables, suites, formulas."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED
from gym_extensions.site.page import pages

from .reading import files, read


def test_a_null_says_why_and_is_not_shown_as_zero(document: dict[str, Any]) -> None:
    document["submissions"] = document["submissions"][:1]
    built = read(document)
    assert "there is no single.csv to pair with" in built["index.html"].said
    assert "there is no single.csv to pair with" in built["submissions/agile.html"].said
    row = dict(files(document))["index.html"].split('data-label="Asymptotic transfer"')[1].split("</td>")[0]
    assert "0.00" not in row
    assert 'class="none"' in row


def test_a_dash_leads_to_its_reason_and_cannot_be_read_as_minus_one(document: dict[str, Any]) -> None:
    page = dict(files(document))["index.html"]
    cell = page.split('data-label="Asymptotic transfer"')[1].split("</td>")[0]
    (note,) = re.findall(r'– <a class="see" href="#([a-z0-9-]+)" title="[^"]+">note 1</a>', cell)
    assert f'<li id="{note}">there is no single.csv to pair with</li>' in page


def test_a_refused_submission_is_listed_with_what_to_do(document: dict[str, Any]) -> None:
    for path in ("index.html", "submissions/broken.html"):
        said = read(document)[path].said
        assert "missing-cell hopper-gravity/sequential.csv, row 7" in said
        assert "Run 0, stage 2 has no episode of gym_extensions/Hopper-v0." in said
        assert "Evaluate every task after every stage." in said


def test_provisional_references_are_said_on_every_page_that_uses_them(document: dict[str, Any]) -> None:
    for path in ("index.html", "submissions/agile.html"):
        assert "rovisional references" in read(document)[path].said
    document["references"]["provisional"] = False
    for path in ("index.html", "submissions/agile.html"):
        assert "rovisional references" not in read(document)[path].said


def test_an_unsolved_task_is_named_and_shows_its_raw_returns(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    scores["reference"]["gym_extensions/Hopper-v0"] = {"floor": 0.0, "ceiling": None, "unsolved": True}
    page = read(document)["submissions/agile.html"]
    assert "Unsolved: Hopper. No reference agent has learned it" in page.said
    assert "raw return (unsolved)" in page.said
    assert any(
        attributes.get("class", "").startswith("unsolved") for tag, attributes in page.elements if tag == "td"
    )


def test_a_group_without_references_is_shown_raw(document: dict[str, Any]) -> None:
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
    assert "No metrics. There is no reference." in page.said
    assert "900" in page.said


def test_a_published_table_shows_what_it_has_and_says_what_it_lacks(document: dict[str, Any]) -> None:
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
    said = pages["submissions/keeper.html"].said
    for words in (
        "For a full entry it still needs logs, 5 runs.",
        "No metrics. Reported: no floor.",
        "Group, as printed 990.95 ± 1022.32",
        "The printed total is not the mean of its rows.",
    ):
        assert words in said
    assert "Evaluation matrix" not in said
    assert "Reported elsewhere" in pages["index.html"].said
    assert "hopper-gravity-v0-sequential-paper" not in pages["index.html"].ids


def test_a_suite_has_a_board_before_its_groups_and_a_row_on_the_entrys_page(document: dict[str, Any]) -> None:
    card = document["submissions"][0]
    scores = card["groups"]["hopper-gravity-v0"]["sequential"]
    bodies = ("hopper", "walker2d", "halfcheetah", "humanoid")
    card["groups"] = {f"{body}-gravity-v0": {"sequential": scores} for body in bodies}
    metrics = {name: {**found, "runs": []} for name, found in scores["metrics"].items()}
    card["suites"] = {
        "gravity": {"sequential": {"budget": "100k", "groups": list(card["groups"]), "metrics": metrics}}
    }
    pages = read(document)
    ids = [name for name in pages["index.html"].ids if name.endswith("-sequential-100k")]
    assert ids[0] == "gravity-sequential-100k"
    assert "gravity suite, mean of 4 groups" in pages["index.html"].said
    assert "gravity suite, mean of 4 groups" in pages["submissions/agile.html"].said


def test_who_leads_a_board_leads_its_ranked_entries(document: dict[str, Any]) -> None:
    """A full entry is another thing: on an entry's page it is one to which nothing is missing."""
    index = read(document)["index.html"].said
    assert "Agile leads the ranked entries with 0.55" in index
    assert "full entr" not in index


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ({"url": "https://example.org/agent", "commit": "abc1"}, "Code https://example.org/agent at abc1"),
        ({"url": "https://example.org/agent", "commit": ""}, "Code https://example.org/agent"),
        ({"url": "", "commit": "abc1"}, "Code commit abc1"),
    ],
)
def test_the_commit_of_the_code_is_said_with_and_without_an_address(
    document: dict[str, Any], code: dict[str, str], said: str
) -> None:
    document["submissions"][0]["manifest"]["code"] = code
    assert said in read(document)["submissions/agile.html"].said
    document["submissions"][0]["manifest"]["code"] = {"url": "", "commit": ""}
    assert " Code " not in read(document)["submissions/agile.html"].said


def test_an_agent_that_learned_nothing_is_not_praised_for_forgetting_nothing(
    document: dict[str, Any],
) -> None:
    assert "nothing learned to forget" in read(document)["submissions/zero.html"].said
    assert "nothing learned to forget" not in read(document)["submissions/agile.html"].said


def test_the_metrics_page_has_every_formula_of_the_scorer() -> None:
    from gym_extensions.scoring.metrics.definitions import METRICS

    page = read(
        {"format": 1, "references": {"version": "x", "provisional": False, "sha256": ""}, "submissions": []}
    )
    said = page["metrics.html"].said
    for metric in (metric for protocol in METRICS.values() for metric in protocol):
        assert re.sub(r"\s+", " ", metric.formula) in said
        assert metric.name in page["metrics.html"].ids


def test_replayed_says_that_a_sample_was_who_draws_it_and_what_is_not_in_it(document: dict[str, Any]) -> None:
    said = read(document)["metrics.html"].said
    assert "replayed A sample of the episodes" in said
    assert "its author could draw again by changing the log" in said
    assert "none of the other cells, on which zero-shot transfer and generalization rest" in said


def test_only_levels_of_trust_that_the_scorer_gives_are_explained(document: dict[str, Any]) -> None:
    page = dict(files(document))["metrics.html"]
    named = re.findall(r'class="trust trust-[a-z-]+">([a-z-]+)<', page)
    assert named == [REPORTED, VALIDATED, "replayed", "refused"]


def test_every_page_module_is_on_the_site_by_being_in_the_folder() -> None:
    import gym_extensions.site.pages as folder

    modules = {path.stem for path in Path(folder.__path__[0]).glob("*.py")} - {"__init__"}
    assert len(pages()) == len(modules) >= 4
    assert [page.order for page in pages()] == sorted(page.order for page in pages())


def test_curves_are_drawn_where_the_document_has_them(document: dict[str, Any]) -> None:
    scores = document["submissions"][0]["groups"]["hopper-gravity-v0"]["sequential"]
    assert "Learning curves" not in read(document)["submissions/agile.html"].said
    points = [[2000 * step, 10.0 * step] for step in range(1, 11)]
    scores["curves"] = [{"run": 0, "task": "gym_extensions/Hopper-v0", "points": points}]
    page = read(document)["submissions/agile.html"]
    assert "Learning curves" in page.said
    assert "gym_extensions/Hopper-v0: training returns, at the end 100" in str(page.elements)


def test_the_board_names_an_entry_whose_results_another_repeats(document: dict[str, Any]) -> None:
    assert "the same results as" not in read(document)["index.html"].said
    copied = copy.deepcopy(document["submissions"][0])
    copied.update(name="copied", title="Something new")
    document["submissions"].insert(1, copied)
    said = read(document)["index.html"].said
    assert "the same results as copied" in said
    assert "the same results as agile" in said
