"""Rank intervals, and the number of runs that would separate two entries."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from scipy import stats

from gym_extensions.scoring.statistics.intervals import Summary, mean_of_groups, subtract, summary
from gym_extensions.scoring.statistics.ranking import rank_intervals, runs_to_separate
from gym_extensions.scoring.statistics.welch import ALPHA, significant_pairs


@pytest.mark.parametrize(
    ("better", "ranks"),
    [("higher", [(4, 4), (1, 2), (2, 3), (1, 3)]), ("lower", [(1, 1), (3, 4), (2, 3), (2, 4)])],
)
def test_rank_intervals_by_hand(better: str, ranks: list[tuple[int, int]]) -> None:
    # Entry 0 is worse than all others, entry 2 worse than entry 1; entry 3 is tied with both.
    entries = [summary([mean, mean + 1]) for mean in (0.0, 7.0, 5.0, 6.0)]
    significant = np.array([[0, 1, 1, 1], [1, 0, 1, 0], [1, 1, 0, 0], [1, 0, 0, 0]], dtype=np.bool_)
    assert rank_intervals(entries, significant, better) == ranks


def test_one_entry_has_rank_one() -> None:
    entries = [summary([1.0, 2.0])]
    assert rank_intervals(entries, significant_pairs(entries), "higher") == [(1, 1)]


def test_the_level_of_one_entry_or_two_is_that_of_one_pair() -> None:
    between = subtract(summary([0.0, 1.0, 2.0]), summary([1.0, 2.0, 3.0]))
    assert runs_to_separate(between, 1) == runs_to_separate(between, 2) == 17


def test_ranks_do_not_depend_on_the_order_of_entries() -> None:
    rng = random.Random(5)
    entries = [summary([rng.gauss(center, 1) for _ in range(5)]) for center in range(8)]
    ranks = rank_intervals(entries, significant_pairs(entries), "higher")
    backwards = rank_intervals(entries[::-1], significant_pairs(entries[::-1]), "higher")
    assert backwards == ranks[::-1]


def entry(mean: float, deviation: float, groups: int = 1, runs: int = 5) -> Summary:
    """An entry with that mean and standard deviation over runs in each of its groups."""
    steps = [index - (runs - 1) / 2 for index in range(runs)]
    unit = math.sqrt(sum(step * step for step in steps) / (runs - 1))
    group = summary([mean + deviation * math.sqrt(groups) * step / unit for step in steps])
    return group if groups == 1 else mean_of_groups([group] * groups)


def needed(gap: float, first: float, second: float, entries: int, groups: int = 1) -> int | None:
    """The number of runs that separates two entries with these deviations on a board of ``entries``."""
    return runs_to_separate(subtract(entry(gap, first, groups), entry(0, second, groups)), entries)


def has_power(runs: int, gap: float, first: list[float], second: list[float], entries: int) -> bool:
    """Whether Welch's test has a power of 80 %, from the definition and the noncentral t of scipy.stats.

    ``first`` and ``second`` are the standard deviations over runs of each entry, one per group.
    """
    count = len(first)
    squares = [deviation * deviation / runs / count**2 for deviation in (*first, *second)]
    df = (runs - 1) * sum(squares) ** 2 / sum(square * square for square in squares)
    critical = stats.t.isf(ALPHA / (entries * (entries - 1) / 2) / 2, df)
    return bool(stats.nct.sf(critical, df, gap / math.sqrt(sum(squares))) >= 0.8)


@pytest.mark.parametrize(("runs", "gap"), [(5, 3.9), (6, 3.8), (10, 2.2), (11, 2.1)])
def test_five_runs_separate_3_9_deviations_on_a_board_of_ten(runs: int, gap: float) -> None:
    assert needed(gap, 1.0, 1.0, 10) == runs


def test_a_difference_of_one_deviation_takes_17_runs() -> None:
    # The entry of any table of sample sizes for d = 1, a power of 80 % and a level of 5 %.
    assert needed(1.0, 1.0, 1.0, 2) == 17


@pytest.mark.parametrize(("gap", "runs"), [(0.401, 99), (0.399, 100), (0.397, None), (0.01, None), (0, None)])
def test_more_than_100_runs_are_none(gap: float, runs: int | None) -> None:
    assert needed(gap, 1.0, 1.0, 2) == runs


def test_the_order_of_the_two_entries_does_not_matter() -> None:
    assert needed(-1.0, 1.0, 0.5, 2) == needed(1.0, 1.0, 0.5, 2) == 12


@pytest.mark.parametrize(("gap", "deviation"), [(1.0, 0.0), (1e6, 1.0), (1.0, 1e-150), (1.0, 1e-161)])
def test_the_result_is_at_least_the_runs_of_a_full_entry(gap: float, deviation: float) -> None:
    assert needed(gap, deviation, deviation, 2) == 5
    assert needed(gap, deviation, deviation, 1000) == 5


def test_a_simulation_has_the_power_of_80_per_cent() -> None:
    rng = random.Random(11)
    runs = needed(1.2, 1.0, 0.5, 2)
    assert runs == 9
    separated = sum(
        significant_pairs(
            [
                summary([rng.gauss(1.2, 1) for _ in range(runs)]),
                summary([rng.gauss(0, 0.5) for _ in range(runs)]),
            ]
        )[0, 1]
        for _ in range(2000)
    )
    assert 0.77 <= separated / 2000 <= 0.88
    assert not has_power(runs - 1, 1.2, [1.0], [0.5], 2)


def test_the_result_is_the_smallest_number_with_the_power() -> None:
    rng = random.Random(13)
    for _ in range(12):
        gap, entries = rng.uniform(0.5, 4), rng.randint(2, 30)
        first, second = rng.uniform(0.1, 2), rng.uniform(0.1, 2)
        candidates = (runs for runs in range(5, 101) if has_power(runs, gap, [first], [second], entries))
        assert needed(gap, first, second, entries) == next(candidates, None)


@pytest.mark.parametrize(("entries", "groups", "runs"), [(10, 1, 25), (10, 4, 23), (2, 1, 12), (2, 4, 11)])
def test_each_group_of_a_suite_adds_degrees_of_freedom(entries: int, groups: int, runs: int) -> None:
    # A difference of 1.25 deviations; four groups have 8 (n − 1) degrees of freedom, one has 2 (n − 1).
    assert needed(1.25, 1.0, 1.0, entries, groups) == runs
    deviations = [math.sqrt(groups)] * groups
    assert [has_power(n, 1.25, deviations, deviations, entries) for n in (runs - 1, runs)] == [False, True]


def test_the_result_on_a_suite_whose_groups_differ_in_deviations_and_runs() -> None:
    rng = random.Random(17)
    for _ in range(12):
        count, entries, gap = rng.randint(2, 6), rng.randint(2, 20), rng.uniform(0.3, 2)
        first, second = ([rng.uniform(0.1, 2) for _ in range(count)] for _ in range(2))
        upper, lower = (
            mean_of_groups([entry(mean, deviation, runs=rng.randint(5, 12)) for deviation in deviations])
            for mean, deviations in ((gap, first), (0.0, second))
        )
        candidates = (runs for runs in range(5, 101) if has_power(runs, gap, first, second, entries))
        assert runs_to_separate(subtract(upper, lower), entries) == next(candidates, None)
