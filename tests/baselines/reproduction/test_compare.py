"""Comparing a run's rows: the first difference, and the rule for evaluation noise with numbers by hand."""

from __future__ import annotations

import pytest

from gym_extensions.baselines.reproduction.compare import compare, welch_p

COLUMNS = ["stage", "task", "episode", "return"]


def rows(*returns: float, stage: int = 1, task: str = "Hopper") -> list[dict[str, str]]:
    return [
        {"stage": str(stage), "task": task, "episode": str(index), "return": repr(value)}
        for index, value in enumerate(returns)
    ]


def test_the_p_value_of_welchs_test_by_hand() -> None:
    # Means 2 and 3, variances 1: t = -1 / sqrt(2/3) = -1.2247 with 4 degrees of freedom.
    assert welch_p([1.0, 2.0, 3.0], [2.0, 3.0, 4.0]) == pytest.approx(0.2879, abs=1e-4)


def test_without_variance_only_equal_means_agree() -> None:
    assert welch_p([2.0, 2.0], [2.0, 2.0]) == 1.0
    assert welch_p([2.0, 2.0], [2.5, 2.5]) == 0.0


def test_equal_rows_are_the_same_bytes() -> None:
    result = compare(rows(1.0, 2.0), rows(1.0, 2.0), COLUMNS)
    assert result.same_bytes
    assert result.agrees


def test_a_small_difference_is_named_and_agrees() -> None:
    result = compare(rows(1.0, 2.0, 3.0), rows(1.0, 2.5, 3.0), COLUMNS)
    assert not result.same_bytes
    assert result.agrees
    assert result.first_difference == (
        "stage 1, Hopper, episode 1: return is 2.0 in the log and 2.5 after retraining"
    )


def test_the_cell_that_differs_is_marked() -> None:
    result = compare(
        rows(1.0, 2.0, 3.0) + rows(5.0, 6.0, 7.0, stage=2),
        rows(1.5, 2.0, 3.0) + rows(85.0, 86.0, 87.0, stage=2),
        COLUMNS,
    )
    assert [(cell.stage, cell.logged, cell.retrained, cell.agrees) for cell in result.cells] == [
        (1, 2.0, pytest.approx(6.5 / 3), True),
        (2, 6.0, 86.0, False),
    ]
    assert not result.agrees


def test_the_level_is_divided_by_the_number_of_cells() -> None:
    # p = .034 alone is significant at .05; with three cells Holm's limit is .05 / 3.
    noisy = rows(1.0, 2.0, 3.0), rows(3.7, 4.7, 5.7)
    assert welch_p([1.0, 2.0, 3.0], [3.7, 4.7, 5.7]) == pytest.approx(0.030, abs=0.01)
    assert not compare(*noisy, COLUMNS).agrees
    same = [row for stage in (2, 3) for row in rows(1.0, 2.0, 3.0, stage=stage)]
    assert compare(noisy[0] + same, noisy[1] + same, COLUMNS).agrees


def test_missing_cells_do_not_agree() -> None:
    result = compare(rows(1.0, 2.0) + rows(1.0, 2.0, stage=2), rows(1.0, 2.0), COLUMNS)
    assert result.first_difference == "the log has 4 rows and the retrained run 2"
    assert not result.agrees
