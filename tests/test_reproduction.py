"""The page on the paper's results: one rule reads the printed and the reproduced numbers."""

from __future__ import annotations

from types import ModuleType

import pytest

from gym_extensions.scoring.metrics.paper_table import PaperCell, PaperRow
from gym_extensions.scoring.published.tables import printed_groups

from .findings_script import findings_script

CELL = PaperCell(1000.0, 100.0)


@pytest.fixture(scope="module")
def page() -> ModuleType:
    return findings_script("reproduction")


def rows(*final: float) -> list[PaperRow]:
    """Tasks with a return of 1,000 ± 100 after training on each and these at the end."""
    return [
        PaperRow(
            f"gym_extensions/Hopper{index}-v0",
            fully_trained=PaperCell(value, 100.0),
            after_env_training=CELL,
            first_step=CELL,
            single_env=CELL,
        )
        for index, value in enumerate(final)
    ]


def test_an_earlier_task_ends_lower_if_the_corrected_test_separates_it(page: ModuleType) -> None:
    table = page.table(rows(500.0, 990.0, 1500.0, 0.0))
    assert [(each.is_separated, each.is_lower) for each in table.changes] == [
        (True, True),
        (False, False),
        (True, False),
    ]
    assert table.forgotten == 1
    assert table.kept == pytest.approx(100 * 2990 / 3000)


def test_the_intervals_are_those_of_welch_over_episodes(page: ModuleType) -> None:
    (change,) = page.table(rows(900.0, 1000.0)).changes
    # Two means of 20 episodes with s² = 100² · 20/19 and 38 degrees of freedom.
    error = (2 * 100.0**2 / 19) ** 0.5
    assert change.gap.mean == pytest.approx(-100.0)
    assert change.gap.high - change.gap.mean == pytest.approx(2.0244 * error, rel=1e-4)


def test_more_episodes_make_the_interval_narrower(page: ModuleType) -> None:
    (few,), (many,) = (page.table(rows(900.0, 1000.0), count).changes for count in (20, 100))
    assert many.gap.high - many.gap.low < 0.5 * (few.gap.high - few.gap.low)


def test_the_rule_reads_the_printed_tables(page: ModuleType) -> None:
    printed = printed_groups("henderson2017")
    hopper, cheetah = (
        page.table(printed[f"{name}-gravity-v0"].table()) for name in ("hopper", "halfcheetah")
    )
    assert (hopper.forgotten, cheetah.forgotten) == (4, 2)
    assert hopper.kept == pytest.approx(34, abs=1)
    assert cheetah.kept == pytest.approx(88, abs=1)


def test_a_claim_holds_if_it_agrees_with_the_number_of_forgotten_tasks(page: ModuleType) -> None:
    forgets, keeps = page.table(rows(500.0, 1000.0)), page.table(rows(1000.0, 1000.0))
    for is_forgotten, shown, answer in (
        (True, forgets, "yes: 1 of 1 earlier tasks end lower, 50 % kept"),
        (True, keeps, "no: 0 of 1 earlier tasks end lower, 100 % kept"),
        (False, forgets, "no: 1 of 1 earlier tasks end lower, 50 % kept"),
        (False, keeps, "not contradicted: 0 of 1 earlier tasks end lower, 100 % kept"),
    ):
        assert (
            page.verdict(page.Group("hopper-gravity", is_forgotten, "an-entry", keeps, shown), shown)
            == answer
        )


def test_the_page_shows_both_sources_and_names_what_is_not_trained(page: ModuleType) -> None:
    table = page.table(rows(500.0, 1000.0))
    text = page.page(
        [
            page.Group("hopper-gravity", True, "hopper", table, None),
            page.Group("halfcheetah-gravity", False, "cheetah", table, table),
        ]
    )
    assert (
        "| hopper-gravity: earlier tasks are forgotten | yes: 1 of 1 earlier tasks end lower, 50 % kept |"
        in text
    )
    assert "kept | not trained yet |" in text
    assert "## hopper-gravity" not in text
    assert "| Hopper0 | 1000 ± 100 | 1000 ± 100 |" in text
    assert "| Hopper0 | −500 (−566 to −434), **separated** |" in text
    assert "* hopper-gravity at this budget." in text
    assert "--out submissions/hopper`" in text
