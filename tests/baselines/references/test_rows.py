"""The rows of the references file, computed by hand."""

from __future__ import annotations

import math
from typing import Any

import pytest

from gym_extensions.baselines.references.rows import beats_floor, floor_row, is_unsolved, summary, task_row

UNSOLVED = [
    # Of fewer than five runs all must beat the floor; of five or more, three.
    ([True], False),
    ([True, False], True),
    ([True, True, True, False], True),
    ([True, True, True, False, False], False),
    ([True, True, False, False, False], True),
    ([False] * 5, True),
]


@pytest.mark.parametrize(("beaten", "expected"), UNSOLVED)
def test_a_task_is_unsolved_unless_enough_runs_beat_the_floor(beaten: list[bool], expected: bool) -> None:
    assert is_unsolved(beaten) is expected


BEATS = [
    # The floor is 0 ± 0.3 and the run's standard error 0.4: together 0.5, five times which is 2.5.
    (2.5, 2.0, True),
    (2.4, 2.0, False),
    # Above by five standard errors, but not by one standard deviation of its episodes.
    (2.9, 3.0, False),
    (3.0, 3.0, True),
]


@pytest.mark.parametrize(("mean", "std", "expected"), BEATS)
def test_a_run_beats_the_floor_by_five_errors_and_one_deviation(
    mean: float, std: float, expected: bool
) -> None:
    run = {"mean": mean, "std": std, "standard_error": 0.4}
    assert beats_floor(run, {"mean": 0.0, "std": 9.0, "standard_error": 0.3}) is expected


def test_a_summary_has_the_population_deviation() -> None:
    # 1, 2, 3, 6: mean 3, squared deviations 4 + 1 + 0 + 9 = 14 over 4.
    expected = {"mean": 3.0, "std": math.sqrt(3.5), "standard_error": math.sqrt(3.5) / 2}
    assert summary([1.0, 2.0, 3.0, 6.0]) == expected


def test_a_floor_is_the_mean_of_the_better_agent() -> None:
    floor = floor_row(
        {"random": [0.0, 2.0] * 8, "zero": [3.0, 5.0] * 8},
        {"random": 11, "zero": 12},
        fingerprint="cd",
        log_sha256="ef",
    )
    # Both have a standard deviation of 1, over √16.
    errors = {"std": 1.0, "standard_error": 0.25}
    assert floor == {
        "mean": 4.0,
        "agent": "zero",
        "budget": None,
        "run": 1000,
        "episodes": 16,
        "standard_error": 0.25,
        "agents": {
            "random": {"mean": 1.0, **errors, "seed": 11},
            "zero": {"mean": 4.0, **errors, "seed": 12},
        },
        "fingerprint": "cd",
        "log_sha256": "ef",
    }


FLOOR = {"mean": 4.0, "standard_error": 0.25}
SOURCE: dict[str, Any] = {"agent": "trpo", "budget": "100k", "log_sha256": "ab"}


def test_the_ceiling_of_a_solved_task_is_the_mean_of_its_runs() -> None:
    row = task_row(FLOOR, {1001: [20.0] * 100, 1000: [30.0] * 100}, **SOURCE)
    assert (row["floor"], row["unsolved"]) == (FLOOR, False)
    # Two runs of 30 and 20: mean 25, sample standard deviation √50, over √2.
    assert (row["ceiling"]["mean"], row["ceiling"]["standard_error"]) == (25.0, pytest.approx(5.0))
    assert [run["run"] for run in row["ceiling"]["runs"]] == [1000, 1001]
    assert row["ceiling"] | SOURCE == row["ceiling"]
    assert "attempts" not in row


def test_an_unsolved_task_has_attempts_in_place_of_a_ceiling() -> None:
    row = task_row(FLOOR, {1000: [3.0]}, **SOURCE)
    assert (row["ceiling"], row["unsolved"]) == (None, True)
    assert row["attempts"]["runs"] == [{"run": 1000, "mean": 3.0, "std": 0.0, "beats_floor": False}]


def test_the_error_of_a_single_run_is_that_of_its_episodes() -> None:
    row = task_row(FLOOR, {1000: [20.0, 24.0] * 8}, agent="oracle", budget="", log_sha256="ab")
    # A standard deviation of 2, over √16.
    assert (row["ceiling"]["mean"], row["ceiling"]["standard_error"]) == (22.0, 0.5)
