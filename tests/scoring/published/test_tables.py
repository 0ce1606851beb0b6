"""The paper as an entry: every printed number, recomputed totals, and each contradiction found by a check."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.scoring.pipeline.score import score_folders
from gym_extensions.scoring.published.consistency import (
    averaged,
    copies,
    deviation_rule,
    mean_agrees,
    pooled,
    repair,
    row_mean,
)
from gym_extensions.scoring.published.tables import PrintedGroup, printed_groups

ENTRY = Path(__file__).parents[3] / "submissions" / "henderson2017-trpo"
PAPER = printed_groups("henderson2017")
TOTALS = [(group, column) for group in PAPER.values() for column in group.total]


@pytest.fixture(scope="module")
def card() -> dict[str, Any]:
    found: dict[str, Any] = score_folders([ENTRY])["submissions"][0]
    return found


def test_all_sixteen_groups_and_285_printed_values_are_there() -> None:
    assert len(PAPER) == 16
    assert sum(len(cells) for group in PAPER.values() for cells in group.rows.values()) == 251
    assert len(TOTALS) == 34


def test_groups_and_tasks_are_ours_in_our_order() -> None:
    ours = {group.id: group.task_ids for group in GROUPS.values()}
    from gym_extensions.scoring.published.tables import task_id

    for group in PAPER.values():
        assert tuple(task_id(name) for name in group.rows) == ours[group.id]


def test_33_of_34_printed_total_means_are_the_means_of_their_rows() -> None:
    wrong = [(group.id, column) for group, column in TOTALS if not mean_agrees(group, column)]
    assert wrong == [("hopper-gravity-v0", "fully_trained")]


def test_the_wrong_total_would_be_right_with_another_row() -> None:
    hopper = PAPER["hopper-gravity-v0"]
    assert list(copies(PAPER)) == [
        (
            ("hopper-gravity-v0", "HopperGravityHalf-v0"),
            ("halfcheetah-gravity-v0", "HalfCheetahGravityHalf-v0"),
        )
    ]
    right = repair(hopper, "fully_trained", "HopperGravityHalf-v0")
    assert (round(right.mean, 2), round(right.std, 1)) == (259.13, 144.0)
    cells = [right, *hopper.column("fully_trained")[1:]]
    assert row_mean(cells) == pytest.approx(990.95)
    assert pooled(cells) == pytest.approx(1022.32)


def test_fully_trained_is_pooled_in_nine_of_ten_groups_and_19_of_the_others_are_averaged() -> None:
    rules: dict[str, list[tuple[str, str]]] = {"pooled": [], "averaged": [], "": []}
    for group, column in TOTALS:
        rules[deviation_rule(group, column)].append((group.id, column))
    assert {column for _, column in rules["pooled"]} == {"fully_trained"}
    assert len(rules["pooled"]) == 9
    assert len(rules["averaged"]) == 19
    assert rules[""] == [
        ("hopper-gravity-v0", "fully_trained"),
        ("hopper-gravity-v0", "first_step"),
        ("hopper-body-v0", "first_step"),
        ("halfcheetah-body-v0", "first_step"),
        ("humanoid-body-v0", "first_step"),
        ("striker-v0", "after_env_training"),
    ]


def test_both_rules_by_hand() -> None:
    pusher = PAPER["pusher-v0"].column("fully_trained")
    assert averaged(pusher) == pytest.approx((2.39 + 7.24) / 2)
    assert pooled(pusher) == pytest.approx(((2.39**2 + 7.24**2) / 2 + ((28.01 - 24.83) / 2) ** 2) ** 0.5)


def test_the_entry_is_reported_shows_what_it_has_and_says_what_it_lacks(card: dict[str, Any]) -> None:
    assert (card["trust"], card["problems"], len(card["groups"])) == ("reported", [], 16)
    scored = card["groups"]["hopper-gravity-v0"]["sequential"]
    assert (scored["runs"], scored["matrix"], scored["budget"]) == ([], [], "paper")
    assert scored["missing"] == ["logs", "5 runs", "the evaluation matrix", "training curves"]
    assert {score["mean"] for score in scored["metrics"].values()} == {None}
    assert scored["table"][3] == {
        "task": "gym_extensions/HopperGravityOneAndQuarter-v0",
        "printed_task": "HopperGravityOneAndQuarter-v0",
        "fully_trained": {"mean": 922.76, "std": 128.71},
        "after_env_training": {"mean": 3006.17, "std": 847.30},
        "first_step": {"mean": 818.08, "std": 255.85},
        "single_env": {"mean": 3028.04, "std": 875.81},
    }
    assert scored["printed_total"]["fully_trained"] == {"mean": 990.95, "std": 1022.32}
    assert scored["total"]["fully_trained"]["mean"] == pytest.approx(1238.31)
    assert card["groups"]["hopper-wall-v0"]["sequential"]["printed_total"]["fully_trained"] is None


def test_nothing_is_computed_from_the_repaired_value(card: dict[str, Any]) -> None:
    assert card["groups"]["hopper-gravity-v0"]["sequential"]["table"][0]["fully_trained"]["mean"] == 1495.93


def test_the_contradictions_of_the_first_group_word_by_word(card: dict[str, Any]) -> None:
    assert card["groups"]["hopper-gravity-v0"]["sequential"]["notes"] == [
        "The printed total mean of Fully Trained, 990.95, is not the mean of its rows, 1238.31.",
        "The row HopperGravityHalf-v0, 1495.93 ± 823.51, repeats HalfCheetahGravityHalf-v0 of "
        "halfcheetah-gravity-v0 digit for digit; 259.13 ± 144.0 in its place would give the printed total. "
        "Nothing here is computed from that value.",
        "The printed total deviation of Fully Trained, 1022.32, is neither that of all episodes pooled, "
        "1029.24, nor the rows' averaged, 495.04.",
        "The printed total deviation of First Step, 184.43, is neither that of all episodes pooled, 354.95, "
        "nor the rows' averaged, 170.97.",
        "HopperGravityHalf-v0 is trained from scratch 2 times, with different results: 2352.19 ± 580.53 "
        "(After Env Training, hopper-gravity-v0); 1843.89 ± 485.25 (Single Env, hopper-gravity-v0).",
    ]


def test_a_table_without_a_mistake_has_no_contradiction() -> None:
    from gym_extensions.scoring.published.consistency import contradictions
    from gym_extensions.scoring.published.tables import Printed

    rows = {
        name: {"fully_trained": cell, "after_env_training": cell}
        for name, cell in (("A-v0", Printed(1.0, 1.0)), ("B-v0", Printed(3.0, 1.0)))
    }
    good = PrintedGroup("good-v0", rows, {"fully_trained": Printed(2.0, 1.41)})
    assert contradictions(good, {"good-v0": good}) == []
    bad = PrintedGroup("bad-v0", rows, {"fully_trained": Printed(2.1, 1.2)})
    assert contradictions(bad, {"bad-v0": bad}) == [
        "The printed total mean of Fully Trained, 2.10, is not the mean of its rows, 2.00.",
        "The printed total deviation of Fully Trained, 1.20, is neither that of all episodes pooled, 1.41, "
        "nor the rows' averaged, 1.00.",
    ]
