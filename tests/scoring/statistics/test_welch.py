"""Welch's test of all pairs and Holm's correction."""

from __future__ import annotations

import math
import random
from itertools import combinations

import numpy as np
import pytest
from scipy import stats

from gym_extensions.scoring.statistics.intervals import Summary, summary
from gym_extensions.scoring.statistics.student_t import two_sided_p
from gym_extensions.scoring.statistics.welch import ALPHA, holm, significant_pairs, welch


def random_board(rng: random.Random, entries: int, spread: float) -> list[list[float]]:
    """Entries of two to nine runs with true means about ``spread`` apart."""
    return [
        [rng.gauss(rng.gauss(0, spread), rng.uniform(0.1, 2)) for _ in range(rng.randint(2, 9))]
        for _ in range(entries)
    ]


def adjusted(p_values: list[float]) -> list[float]:
    """Holm's adjusted p values, from their definition."""
    ascending = sorted(p_values)
    return [
        max(min(1.0, (len(p_values) - rank) * p) for rank, p in enumerate(ascending) if p <= value)
        for value in p_values
    ]


@pytest.mark.parametrize(
    ("p_values", "rejected"),
    [
        # .01 ≤ .05/4, .013 ≤ .05/3, .03 > .05/2: it stops, although .04 ≤ .05.
        ([0.03, 0.01, 0.04, 0.013], [False, True, False, True]),
        ([0.05], [True]),
        ([0.051], [False]),
        ([0.025, 0.025], [True, True]),
        ([], []),
    ],
)
def test_holms_procedure_by_hand(p_values: list[float], rejected: list[bool]) -> None:
    assert holm(np.array(p_values)).tolist() == rejected


@pytest.mark.parametrize("alpha", [0.05, 0.2])
def test_holms_procedure_rejects_where_the_adjusted_p_value_is_at_most_alpha(alpha: float) -> None:
    rng = random.Random(3)
    for _ in range(200):
        p_values = [rng.random() ** 4 for _ in range(rng.randint(1, 12))]
        assert holm(np.array(p_values), alpha).tolist() == [p <= alpha for p in adjusted(p_values)]


def test_welchs_test_by_hand() -> None:
    # Squared errors 1/3 and 4/3, difference -2: t = -2 / √(5/3), df = (5/3)² / ((1/3)²/2 + (4/3)²/2).
    t, df = welch([summary([0.0, 1.0, 2.0]), summary([1.0, 3.0, 5.0])])
    assert (t.tolist(), df.tolist()) == (pytest.approx([-2 / math.sqrt(5 / 3)]), pytest.approx([50 / 17]))


def test_welchs_test_of_all_pairs_agrees_with_scipy_stats() -> None:
    runs = random_board(random.Random(7), 20, 3.0)
    t, df = welch([summary(values) for values in runs])
    expected = [stats.ttest_ind(a, b, equal_var=False) for a, b in combinations(runs, 2)]
    assert t == pytest.approx([test.statistic for test in expected], rel=1e-9)
    assert df == pytest.approx([test.df for test in expected], rel=1e-9)
    assert two_sided_p(t, df) == pytest.approx([test.pvalue for test in expected], rel=1e-9)


@pytest.mark.parametrize("spread", [0.0, 1.0, 3.0, 10.0, 30.0])
def test_significant_pairs_are_those_of_scipy_stats_with_holms_correction(spread: float) -> None:
    rng = random.Random(2)
    for entries in (2, 3, 10, 40):
        runs = random_board(rng, entries, spread)
        samples = [(float(np.mean(row)), float(np.std(row, ddof=1)), float(len(row))) for row in runs]
        pairs = [(*a, *b) for a, b in combinations(samples, 2)]
        p_values = stats.ttest_ind_from_stats(*np.transpose(pairs), equal_var=False).pvalue.tolist()
        significant = significant_pairs([summary(values) for values in runs])
        assert significant[np.triu_indices(entries, 1)].tolist() == [p <= ALPHA for p in adjusted(p_values)]
        assert (significant == significant.T).all()
        assert not significant.diagonal().any()


def test_entries_without_variance_differ_if_their_means_do() -> None:
    entries = [summary([1.0] * 5), summary([1.0] * 5), summary([2.0] * 5)]
    t, df = welch(entries)
    assert (t.tolist(), df.tolist()) == ([0, -math.inf, -math.inf], [8, 8, 8])
    expected = [[False, False, True], [False, False, True], [True, True, False]]
    assert significant_pairs(entries).tolist() == expected


def test_one_entry_has_no_pair() -> None:
    assert significant_pairs([summary([1.0, 2.0])]).tolist() == [[False]]
    assert significant_pairs([]).shape == (0, 0)


def test_degrees_of_freedom_are_at_least_the_smaller_ones_where_squares_underflow() -> None:
    # The square of 3.85e-162 is three times the smallest positive number, a quarter of it rounds to one.
    entries = [Summary(0.0, 3.85e-162, 4.0, 5, 0.0, 0.0), Summary(1.0, 0.0, 9.0, 10, 0.0, 0.0)]
    assert welch(entries)[1].tolist() == [4.0]


def test_a_board_of_a_thousand_entries() -> None:
    # Three clusters with true means 0, 100 and 200 and runs of deviation 1: a cluster is not split.
    rng = np.random.default_rng(5)
    cluster = np.arange(1000) % 3
    entries = [summary(row) for row in (100 * cluster[:, None] + rng.normal(0, 1, (1000, 10))).tolist()]
    significant = significant_pairs(entries)
    apart = cluster[:, None] != cluster
    assert significant[apart].all()
    assert significant[~apart].sum() <= 2
