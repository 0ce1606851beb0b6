"""The overview: which method leads on the core, how certain that is, and what the others lack."""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

from gym_extensions.catalog.groups import CORE, CORES, GROUPS as GROUP_IDS, SUITES, group
from gym_extensions.scoring.ranking.group_board import boards
from gym_extensions.site.pages import core
from gym_extensions.site.pages.overview import Overview
from gym_extensions.site.text import split_version

from ..browser import Pages, files, read, typed
from ..conftest import MADE, everything, make_submission, scored

GROUPS = [split_version(group_id)[0] for group_id in CORES[CORE]]


def method(
    name: str, strength: float, keeps: float, groups: Sequence[str] = GROUPS, timed: int = 1
) -> dict[str, Any]:
    """A submission with five runs on groups of the core: what it learns, and which share of it is left."""
    made = {each: {**MADE, "cpu_seconds": 1260.0 if each in GROUPS[:timed] else None} for each in groups}
    scores = {each: scored(each, _runs(each, strength, keeps), "300k") for each in groups}
    logs = {f"{each}-v0": {"sequential": scores[each] | {"provenance": [made[each]]}} for each in groups}
    return make_submission(name, logs, name.title())


def trained_here(name: str) -> dict[str, Any]:
    """A submission with five runs of its author on the core, and five that the project trained."""
    other, card = method(name, 0.8, 0.5), method(name, 0.7, 0.5)
    own = {each: of["sequential"] for each, of in other["groups"].items()}
    groups = {
        each: of | {"sequential": of["sequential"] | {"level": "trained here"}}
        for each, of in card["groups"].items()
    }
    facts = {"date": "2026-01-02", "version": "1.0.0", "commit": "3f" * 20, "value": "", "agent": "4e" * 32}
    return card | {
        "groups": groups,
        "own": own,
        "training": facts | {"attempts": 2, "outdated": False, "failed": {}},
    }


def _runs(name: str, strength: float, keeps: float) -> list[list[list[float]]]:
    count = len(group(name).tasks)
    return [
        [[strength + run] * count]
        + [
            [1000 * strength * (1 + run / 50) * (keeps if j + 1 < stage else j < stage) for j in range(count)]
            for stage in range(1, count + 1)
        ]
        for run in range(5)
    ]


def overview_of(*cards: dict[str, Any]) -> Overview:
    """The overview of these submissions."""
    document = typed({**everything(), "submissions": list(cards)})
    found = boards(document.submissions)
    assert found.core is not None
    return Overview(found.core, {card.name: card for card in document.submissions}, found.boards, {})


def statement(*cards: dict[str, Any]) -> str:
    """The statement, without markup."""
    return overview_of(*cards).statement().striptags()


KEEPER, LOSER, TWIN = method("keeper", 0.8, 0.98), method("loser", 0.8, 0.5), method("twin", 0.81, 0.5)
PART = method("part", 0.9, 0.9, GROUPS[:2])
LABELLED, OTHER = method("labelled", 0.9, 1.0), method("other", 0.6, 1.0)
for card in (LABELLED, OTHER):
    card["manifest"]["observes"]["task_in_evaluation"] = True


def test_a_single_complete_method_does_not_lead() -> None:
    assert statement(KEEPER, PART).startswith(
        "Keeper is the only method with all runs of the core suite so far"
    )
    assert statement(PART).startswith("No method has all runs of the core suite yet.")


def test_the_statement_says_of_how_many_methods_where_they_lead_and_that_it_is_preliminary() -> None:
    said = statement(KEEPER, LOSER, TWIN)
    assert said.startswith("Of 3 methods without task label that ran all 7 groups, Keeper keeps most, 0.82 (")
    assert said.endswith(
        "significantly ahead of all others in 7 of 7. Compared on 5 runs per method; preliminary."
    )
    assert len(said.split()) < 50
    view = overview_of(KEEPER, LOSER, TWIN)
    second = replace(view, board=replace(view.board, edition=2)).statement().striptags()
    assert second.endswith("5 runs per method; exploratory.")
    lost = statement(KEEPER, method("trpo", 0.8, 0.5))
    assert lost.startswith("Trained task after task, Trpo falls from 0.83 to 0.55 (expert: 1). Of 2 methods")


def test_methods_with_the_task_label_count_only_without_others() -> None:
    assert "Of 2 methods without task label" in statement(KEEPER, LOSER, LABELLED, OTHER)
    assert "Of 2 methods that ran" in statement(LABELLED, OTHER)


def test_the_highest_mean_does_not_keep_most_if_the_others_are_better_over_the_runs_compared() -> None:
    view = overview_of(KEEPER, LOSER, TWIN)
    turned = tuple(replace(pair, mean=-pair.mean) for pair in view.board.pairs[core.FINAL])
    changed = replace(view.board, pairs={**view.board.pairs, core.FINAL: turned})
    said = replace(view, board=changed).statement().striptags()
    assert said.endswith("; no difference is significant.")
    assert "Twin has the highest mean, 0.56" in statement(LOSER, TWIN)


def test_limits_name_what_the_statement_does_not_show() -> None:
    limits = overview_of(KEEPER, LOSER, PART).limits()
    assert (limits["ranked"], limits["lacking"], limits["untuned"]) == (2, ["part"], 2)
    assert limits["most_tuned"][0] == 0
    tuned = [
        {**each, "manifest": each["manifest"] | {"tuning": {"steps": 9, "tasks": []}}}
        for each in (KEEPER, TWIN)
    ]
    assert overview_of(LOSER, *tuned).limits()["most_tuned"] == (9, ["keeper", "twin"])
    for cards, untuned in (([LOSER, *tuned], ["1"]), (tuned, [])):
        page = dict(files({**everything(), "submissions": cards}))["index.html"]
        assert re.findall(r"not at all for (\d+) of them", page) == untuned
    assert overview_of(PART).limits() == {}


def test_a_cell_says_how_a_method_compares_with_the_best_of_its_list_on_the_group() -> None:
    view = overview_of(KEEPER, LOSER, TWIN, PART)
    kinds = {row.name: [cell.kind for cell in view.cells(row)] for row in view.board.rows}
    assert kinds["keeper"] == ["tied"] * 2 + ["best"] * 5, "part is better on two groups"
    assert {*kinds["loser"]} == {"lower"}
    assert kinds["part"][:2] == ["best"] * 2
    (part,) = (row for row in view.board.rows if row.name == "part")
    assert [cell.value is None for cell in view.cells(part)] == [False] * 2 + [True] * 5
    assert view.numbers(part).split(";")[0].endswith(" - - - - -")


def test_groups_compare_the_runs_that_the_core_compares() -> None:
    view = overview_of(trained_here("trpo"), trained_here("other"))
    assert {cell.kind for row in view.ranked for cell in view.cells(row)} <= {"best", "lower", "tied"}


def test_runs_that_were_trained_here_are_not_of_the_first_arithmetic() -> None:
    old = {"arithmetic": 1}
    view = overview_of(KEEPER | old, LOSER, trained_here("trpo") | old)
    assert view.of_first_arithmetic == 1


def test_a_method_that_learned_nothing_is_not_said_to_have_learned_little() -> None:
    page = dict(files({**everything(), "submissions": [KEEPER, method("nothing", 0.0, 0.0)]}))["index.html"]
    assert "nothing learned</i>" in page and "little learned</i>" not in page


def test_a_method_that_lacks_groups_says_which() -> None:
    (part,) = typed({**everything(), "submissions": [method("part", 1, 1, GROUPS[2:])]}).submissions
    assert part.core is not None
    assert core.state(part.core) == f"lacks {GROUPS[0]}, {GROUPS[1]}"
    assert part.core.metrics[core.FINAL].mean is None
    assert typed(everything()).submissions[0].core is None


def test_a_point_lies_at_learned_and_kept_below_the_line_where_nothing_is_lost() -> None:
    board = overview_of(KEEPER, LOSER, PART).board
    drawing = ElementTree.fromstring(core.figure(board.rows))
    points = drawing.findall("circle")
    assert [dot.get("class") for dot in points] == ["method other", "method first"]
    assert "keeper" in str(points[1].findtext("title")), "the first is drawn last, above the others"
    for dot in points:
        assert core.TOP + core.SIDE - float(dot.get("cy", 0)) < float(dot.get("cx", 0)) - core.LEFT
    assert len(drawing.findall("path[@class='whisker first']")) == 1
    assert [label.text for label in drawing.findall("text[@class='label']")] == ["keeper", "loser"]
    assert core.figure(board.rows[2:]) == ""


def test_the_overview_has_every_method_of_both_lists_and_27_take_60_kilobytes() -> None:
    many = [method(f"{'n' * 55}-{at:02d}", 0.5, 0.5) for at in range(25)]
    for at, card in enumerate(many):
        card["manifest"]["observes"]["task_in_evaluation"] = at > 12
        card["title"] = "\N{SMILING FACE WITH SUNGLASSES}" * 200
    document = {**everything(), "submissions": [KEEPER, LOSER, *many]}
    texts = dict(files(document))
    index, page = texts["index.html"], Pages(texts)
    assert index.count('<tr id="method-') == 27
    assert len(index.encode()) < 60_000
    cards = [a["href"] for tag, a in page["groups.html"].elements if a.get("href", "").startswith("groups/")]
    assert cards[: len(GROUPS)] == [f"groups/{group_id}.html" for group_id in CORES[CORE]]
    assert len(cards) == len(set(cards)) == len(GROUP_IDS) + len(SUITES)
    assert "Kept ( core score ) 0.82" in page["submissions/keeper.html"].text


def test_the_page_has_the_notes_and_the_parameters_of_every_method() -> None:
    more = method("more", 0.5, 0.5)
    scores = scored(GROUPS[0], [*_runs(GROUPS[0], 0.5, 0.5), *_runs(GROUPS[0], 0.4, 0.5)[:1]], "300k")
    more["groups"][f"{GROUPS[0]}-v0"]["sequential"] |= scores | {"provenance": [MADE] * 6}
    pages = read({**everything(), "submissions": [more | {"name": "also"}, KEEPER, more, PART]})
    page = pages["core.html"].text
    note = f"Compared: runs 0 to 4. Waiting until every group has 10 runs: run 5 of {GROUPS[0]}-v0."
    assert f"Core score: {note}" in pages["submissions/more.html"].text
    assert f"also , more : {note}" in page, "methods with the same note share a sentence"
    assert page.count("2 000") == 4, "the transitions of each, also of the one that lacks groups"


def test_a_cost_is_steps_and_where_some_runs_state_it_a_time() -> None:
    (card,) = typed({**everything(), "submissions": [method("part", 1, 1, GROUPS[:3])]}).submissions
    cost = ("4.5M steps in 3 groups", "21 min in 1 of 3 groups, mean of 1 run per group")
    assert core.cost(card) == core.cost(replace(card, core=None)) == cost
    tiny = method("tiny", 1, 1, GROUPS[:1])
    for run in tiny["groups"][f"{GROUPS[0]}-v0"]["sequential"]["provenance"]:
        run.update(steps=5000, cpu_seconds=2.4)
    (tiny_card,) = typed({**everything(), "submissions": [tiny]}).submissions
    assert core.cost(tiny_card) == (
        "5\N{NARROW NO-BREAK SPACE}000 steps in 1 group",
        "2 s, mean of 1 run per group",
    )
    (bare,) = typed({**everything(), "submissions": [make_submission("bare", {})]}).submissions
    assert core.cost(bare) == ("–", "")
