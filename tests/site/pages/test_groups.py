"""Pages of groups and suites: tasks, references, printed tables and what a score of 1 means."""

import re
from typing import Any

from gym_extensions.baselines.training.jobs import parse_groups
from gym_extensions.catalog.groups import SUITES
from gym_extensions.references import load_references

from ..browser import read
from ..conftest import missing, scores_of
from .test_core import method


def test_an_open_task_is_named_and_has_raw_returns(document: dict[str, Any]) -> None:
    scores = scores_of(document)
    scores["reference"]["gym_extensions/Hopper-v0"] = {"floor": 0.0, "expert": None, "open": True}
    page = read(document)["submissions/agile.html"]
    assert "Open, not scored: Hopper. No expert is known that is clearly better than the floor" in page.text
    assert "raw return (open)" in page.text
    assert any(
        attributes.get("class", "").startswith("open") for tag, attributes in page.elements if tag == "td"
    )


def test_a_published_table_shows_what_it_has(document: dict[str, Any]) -> None:
    table = document["submissions"][1]
    table.update(level="reported", groups={"hopper-gravity-v0": table["groups"]["hopper-gravity-v0"]})
    scores = table["groups"]["hopper-gravity-v0"]["sequential"]
    scores.update({"level": "reported", "budget": "paper", "runs": [], "return_matrix": []})
    scores.update(
        metrics=dict.fromkeys(scores["metrics"], missing("Reported: no floor.")),
        printed_total={**scores["paper_total"], "fully_trained": {"mean": 990.95, "std": 1022.32}},
        notes=["The printed total is not the mean of its rows."],
    )
    pages = read(document)
    text = pages["submissions/keeper.html"].text
    for sentence in (
        "No metrics. Reported: no floor.",
        "Group, as printed 990.95 ± 1022.32",
        "The printed total is not the mean of its rows.",
    ):
        assert sentence in text
    assert "Evaluation matrix" not in text
    assert "Keeper keeper reported" in pages["submissions.html"].text
    assert "boards/hopper-gravity-v0-sequential-paper.html" not in pages


def test_a_suite_has_a_page_a_board_and_a_row_on_the_page_of_the_submission(document: dict[str, Any]) -> None:
    card = document["submissions"][0]
    scores = card["groups"]["hopper-gravity-v0"]["sequential"]
    bodies = ("hopper", "walker2d", "halfcheetah", "humanoid")
    card["groups"] = {f"{body}-gravity-v0": {"sequential": scores} for body in bodies}
    metrics = {name: {**value, "runs": []} for name, value in scores["metrics"].items()}
    card["suites"] = {
        "gravity": {"sequential": {"budget": "100k", "groups": list(card["groups"]), "metrics": metrics}}
    }
    pages = read(document)
    assert "gravity suite Agile" in pages["groups.html"].text
    for path in ("groups/gravity.html", "boards/gravity-sequential-100k.html", "submissions/agile.html"):
        assert "gravity suite, mean of 4 groups" in pages[path].text


def test_a_suite_that_nobody_entered_names_the_groups_to_train_on(document: dict[str, Any]) -> None:
    (names,) = re.findall(r"--groups (\S+) --out", read(document)["groups/navigation.html"].text)
    assert [each.id for each in parse_groups(names.split(","))] == list(SUITES["navigation"])


def test_a_submission_on_several_groups_has_a_page_of_results_per_group(document: dict[str, Any]) -> None:
    built = read(document)
    paths = [f"submissions/keeper/{body}-gravity-v0.html" for body in ("hopper", "walker2d")]
    links = {a.get("href", "") for _, a in built["submissions/keeper.html"].elements}
    for path in paths:
        assert "Evaluation matrix" in built[path].text
        assert any(link.startswith(f"../{path}#") for link in links)
    assert "Evaluation matrix" not in built["submissions/keeper.html"].text
    assert "Evaluation matrix" in built["submissions/agile.html"].text
    assert not [path for path in built if path.startswith("submissions/agile/")]


def test_a_group_page_says_what_one_means_and_which_experts_are_provisional_or_missing(
    document: dict[str, Any],
) -> None:
    current = load_references()
    document["references"] = {"version": current.version, "sha256": current.digest}
    document["submissions"].append(method("part", 0.9, 0.9, ["hopper-wall"]))
    pages = read(document)
    cheetah = pages["groups/halfcheetah-gravity-v0.html"].text
    assert re.search(r"1 = expert: return \d+\. 0 = the zero action: return −?\d", cheetah)
    assert pages["core.html"].text.count("Provisional:") == 1
    assert "(provisional: it rarely passes the wall)" in pages["groups/hopper-wall-v0.html"].text
    assert "Open: no expert is known that is clearly better than 0" in pages["groups/striker-v0.html"].text
    document["references"]["sha256"] = "00" * 32
    assert "No reference has been measured. " in read(document)["groups/halfcheetah-gravity-v0.html"].text


def test_a_page_has_a_tab_per_board_and_one_of_its_tasks(document: dict[str, Any]) -> None:
    page = read(document)["groups/hopper-gravity-v0.html"]
    tabs = [a["href"] for tag, a in page.elements if a.get("class", "").startswith("to-")]
    panels = [f"#{a['id']}" for tag, a in page.elements if a.get("class", "").startswith("panel-")]
    kinds = [
        f"{protocol}-100k{observes}"
        for protocol in ("sequential", "single")
        for observes in ("", "-task-conditioned")
    ]
    assert tabs == panels == [*(f"#hopper-gravity-v0-{kind}" for kind in kinds), "#tasks"]


def test_forgetting_that_rounds_to_zero_is_not_called_an_improvement(document: dict[str, Any]) -> None:
    said = []
    for keeps in (1.00001, 1.1):
        document["submissions"] = [method("a", 0.8, keeps)]
        text = read(document)["groups/hopper-gravity-v0.html"].text
        said.append("below 0, because later training improved" in text.partition("Least forgetting")[2])
    assert said == [False, True]
