"""The paper as a submission: every printed number, and the frozen findings computed again."""

import math
from pathlib import Path

import pandas as pd
import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.scoring.group_score import PAPER_COLUMNS, GroupScore, PaperCell, PaperRow
from gym_extensions.scoring.pipeline import make_scorer, score_folder
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission import reported_tables

SUBMISSION = Path(__file__).parents[3] / "submissions" / "henderson2017-trpo"
pytestmark = pytest.mark.committed
TABLE = pd.read_csv(reported_tables.table_path("henderson2017")).replace(
    {"column": reported_tables.PRINTED_COLUMNS}
)
TABLE["group"] = TABLE["group"].map(reported_tables.group_id)
ROWS, TOTALS = TABLE[TABLE["env"] != "TOTAL"], TABLE[TABLE["env"] == "TOTAL"]
"""What the paper prints: a mean and a deviation per group, environment and column, and totals of groups."""


@pytest.fixture(scope="module")
def card() -> Scorecard:
    return score_folder(SUBMISSION)


@pytest.fixture(scope="module")
def hopper(card: Scorecard) -> GroupScore:
    return card.groups["hopper-gravity-v0"]["sequential"]


def test_only_the_chosen_groups_are_scored(hopper: GroupScore) -> None:
    card = make_scorer(only=["hopper-gravity"])(SUBMISSION)
    assert card.groups == {"hopper-gravity-v0": {"sequential": hopper}}


def test_the_frozen_totals_are_those_of_the_printed_rows() -> None:
    """The deviation of all episodes together is √(mean(σ²) + population variance of the means)."""
    frozen: dict[object, PaperCell] = {
        (group, column): total
        for group, finding in reported_tables.findings("henderson2017").items()
        for column in PAPER_COLUMNS
        if (total := getattr(finding.paper_total, column))
    }
    columns = dict(list(ROWS.groupby(["group", "column"])))
    assert set(frozen) == set(columns)
    for key, cells in columns.items():
        pooled = math.sqrt((cells["std"] ** 2).mean() + cells["mean"].var(ddof=0))
        assert (frozen[key].mean, frozen[key].std) == pytest.approx((cells["mean"].mean(), pooled)), key


def test_all_sixteen_groups_and_285_printed_values_are_there() -> None:
    assert (ROWS["group"].nunique(), len(ROWS), len(TOTALS)) == (16, 251, 34)


def test_groups_and_tasks_are_ours_in_our_order() -> None:
    printed = {
        group: tuple(map(reported_tables.task_id, cells["env"].unique()))
        for group, cells in ROWS.groupby("group")
    }
    ours = {group.id: group.task_ids for group in GROUPS.values()}
    assert {group: ours.get(str(group)) for group in printed} == printed


def test_the_submission_is_reported_and_says_what_it_lacks(card: Scorecard, hopper: GroupScore) -> None:
    assert (card.level, card.problems, len(card.groups)) == ("reported", (), 16)
    assert (hopper.runs, hopper.return_matrix, hopper.budget) == ((), (), "paper")
    assert {value.mean for value in hopper.metrics.values()} == {None}


def test_a_row_is_as_printed_and_totals_are_printed_and_recomputed(
    card: Scorecard, hopper: GroupScore
) -> None:
    assert hopper.paper_table[3] == PaperRow(
        task="gym_extensions/HopperGravityOneAndQuarter-v0",
        printed_task="HopperGravityOneAndQuarter-v0",
        fully_trained=PaperCell(922.76, 128.71),
        after_env_training=PaperCell(3006.17, 847.30),
        first_step=PaperCell(818.08, 255.85),
        single_env=PaperCell(3028.04, 875.81),
    )
    wall = card.groups["hopper-wall-v0"]["sequential"].printed_total
    assert hopper.printed_total and hopper.paper_total and hopper.paper_total.fully_trained and wall
    assert hopper.printed_total.fully_trained == PaperCell(990.95, 1022.32)
    assert hopper.paper_total.fully_trained.mean == pytest.approx(1238.31)
    assert wall.fully_trained is None
