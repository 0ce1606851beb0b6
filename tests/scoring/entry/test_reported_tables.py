"""The paper as an entry: every printed number, and the frozen findings computed again."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.scoring.entry.reported_tables import findings, task_id
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.scorecard import (
    PAPER_COLUMNS,
    GroupScore,
    PaperCell,
    PaperColumns,
    PaperRow,
    Scorecard,
)

from ..consistency import pooled, printed_groups, row_mean

ENTRY = Path(__file__).parents[3] / "submissions" / "henderson2017-trpo"
PAPER = printed_groups("henderson2017")
TOTALS = [(group, column) for group in PAPER.values() for column in group.total]


@pytest.fixture(scope="module")
def card() -> Scorecard:
    return score_folder(ENTRY)


@pytest.fixture(scope="module")
def hopper(card: Scorecard) -> GroupScore:
    return card.groups["hopper-gravity-v0"]["sequential"]


def test_the_frozen_totals_are_those_of_the_printed_rows() -> None:
    frozen = findings("henderson2017")
    assert set(frozen) == set(PAPER)
    for group in PAPER.values():
        cells = {column: group.column(column) for column in PAPER_COLUMNS}
        totals = {name: PaperCell(row_mean(c), pooled(c)) if c else None for name, c in cells.items()}
        assert frozen[group.id].paper_total == PaperColumns(**totals), group.id


def test_all_sixteen_groups_and_285_printed_values_are_there() -> None:
    assert len(PAPER) == 16
    assert sum(len(cells) for group in PAPER.values() for cells in group.rows.values()) == 251
    assert len(TOTALS) == 34


def test_groups_and_tasks_are_ours_in_our_order() -> None:
    ours = {group.id: group.task_ids for group in GROUPS.values()}
    for group in PAPER.values():
        assert tuple(task_id(name) for name in group.rows) == ours[group.id]


def test_the_entry_is_reported_and_says_what_it_lacks(card: Scorecard, hopper: GroupScore) -> None:
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
    assert hopper.printed_total is not None
    assert hopper.printed_total.fully_trained == PaperCell(990.95, 1022.32)
    assert hopper.paper_total is not None
    assert hopper.paper_total.fully_trained is not None
    assert hopper.paper_total.fully_trained.mean == pytest.approx(1238.31)
    wall = card.groups["hopper-wall-v0"]["sequential"].printed_total
    assert wall is not None
    assert wall.fully_trained is None
