"""Statistics: by hand, and against ``scipy.stats``."""

import math
import random
from itertools import combinations

import numpy as np
import pytest
from scipy import stats

from gym_extensions.metrics import statistics
from gym_extensions.metrics.formulas import iqm
from gym_extensions.metrics.statistics import Interval, Summary, summary, to_interval


def test_the_mean_of_an_empty_input_is_none() -> None:
    assert statistics.mean([]) is None
    assert statistics.mean(iter([1.0, 2.0, 6.0])) == 3.0


def test_the_mean_is_summed_exactly() -> None:
    assert statistics.mean([0.1] * 10) == 0.1
    assert statistics.mean([1e16, 1.0, -1e16, 1.0]) == 0.5


DF = [1.0, 1.2, 1.5, 2.0, 2.5, 4.0, 8.0, 30.0, 200.0, 1e4]


@pytest.mark.parametrize("df", DF)
@pytest.mark.parametrize("alpha", [0.05, 0.05 / 45, 0.05 / 499_500])
def test_the_p_value_of_a_critical_value_is_alpha(alpha: float, df: float) -> None:
    p_value = statistics.zero_mean_p(Summary(statistics.critical_value(alpha, df), 1.0, df, 2))
    assert p_value == pytest.approx(alpha, rel=1e-12)


def test_runs_without_variance_have_an_interval_without_width() -> None:
    assert statistics.interval([0.25] * 3) == Interval(0.25, 0.25, 0.25, 0.0, 2)
    assert statistics.difference([1.0, 1.0], [3.0, 3.0]) == Interval(-2.0, -2.0, -2.0, 0.0, 2.0)


@pytest.mark.parametrize("df", [1, 1.2, 2, 4, 7.3, 200, 1e4])
def test_the_quantile_of_an_interval_has_12_significant_digits(df: float) -> None:
    value = statistics.critical_value(0.05, df)
    assert len(repr(value).replace(".", "")) <= 12
    assert value == pytest.approx(float(stats.t.ppf(0.975, df)), rel=1e-11)


def test_a_summary_by_hand() -> None:
    assert summary([1.0, 3.0, 5.0]) == Summary(3.0, 4 / 3, 2.0, 3)
    assert summary([2.0]) == Summary(2.0, 0.0, 0.0, 1)


def test_the_mean_of_groups_by_hand() -> None:
    # Squared errors 4/3 and 1/3 over 4: total 5/12; df = (5/12)² / ((1/3)²/2 + (1/12)²/2) = 50/17.
    result = statistics.mean_of_groups([summary([1.0, 3.0, 5.0]), summary([1.0, 2.0, 3.0])])
    assert (result.mean, result.runs) == (2.5, 3)
    assert (result.squared_error, result.df) == pytest.approx((5 / 12, 50 / 17), rel=1e-14)


def test_welch_satterthwaite_by_hand() -> None:
    assert statistics.welch_satterthwaite([(1.0, 4.0), (3.0, 2.0)]) == (2.0, 16 / (1 / 4 + 9 / 2))
    assert statistics.welch_satterthwaite([(1.0, 4.0), (0.0, 2.0)]) == (1.0, 4.0)
    assert statistics.welch_satterthwaite([(0.0, 4.0), (0.0, 2.0)]) == (0.0, 6.0)


def test_degrees_of_freedom_are_at_least_the_smallest_where_squares_underflow() -> None:
    # The square of 3.85e-162 is three times the smallest positive number, a quarter of it rounds to one.
    assert statistics.welch_satterthwaite([(3.85e-162, 4.0), (0.0, 9.0)])[1] == 4.0


@pytest.mark.parametrize("values", [[0.1, 0.4, 0.2], [-3.0, 1.0], [1e-9, 2e-9, -4e-9, 1e-9], [5.0, 6.0, 5.5]])
def test_the_p_value_is_that_of_scipy(values: list[float]) -> None:
    assert statistics.zero_mean_p(summary(values)) == pytest.approx(
        stats.ttest_1samp(values, 0.0).pvalue, rel=1e-12
    )


@pytest.mark.parametrize(("values", "p_value"), [([0.0, 0.0], 1.0), ([2.0, 2.0], 0.0), ([-1.0, 1.0], 1.0)])
def test_without_variance_a_mean_is_zero_or_it_is_not(values: list[float], p_value: float) -> None:
    assert statistics.zero_mean_p(summary(values)) == p_value


def random_board(rng: random.Random, submissions: int, spread: float) -> list[list[float]]:
    """Submissions of two to nine runs with true means about ``spread`` apart."""
    return [
        [rng.gauss(rng.gauss(0, spread), rng.uniform(0.1, 2)) for _ in range(rng.randint(2, 9))]
        for _ in range(submissions)
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
    assert statistics.holm(np.array(p_values)).tolist() == rejected


def test_adjusted_p_values_are_those_of_the_definition() -> None:
    for p_values in ([], [0.02], [0.03, 0.01, 0.04, 0.013], [0.5, 0.5, 0.9], [0.01] * 4):
        assert statistics.holm_adjusted(np.array(p_values)).tolist() == pytest.approx(
            adjusted(p_values), rel=1e-14
        )


@pytest.mark.parametrize("spread", [0.0, 1.0, 3.0, 10.0, 30.0])
def test_significant_pairs_are_those_of_scipy_stats_with_holms_correction(spread: float) -> None:
    rng = random.Random(2)
    for submissions in (2, 3, 10, 40):
        runs = random_board(rng, submissions, spread)
        samples = [(float(np.mean(row)), float(np.std(row, ddof=1)), float(len(row))) for row in runs]
        pairs = [(*a, *b) for a, b in combinations(samples, 2)]
        p_values = stats.ttest_ind_from_stats(*np.transpose(pairs), equal_var=False).pvalue.tolist()
        significant = statistics.significant_pairs([summary(values) for values in runs])
        assert significant[np.triu_indices(submissions, 1)].tolist() == [
            p <= statistics.ALPHA for p in adjusted(p_values)
        ]
        assert (significant == significant.T).all()
        assert not significant.diagonal().any()


def test_submissions_without_variance_differ_if_their_means_do() -> None:
    submissions = [summary([1.0] * 5), summary([1.0] * 5), summary([2.0] * 5)]
    expected = [[False, False, True], [False, False, True], [True, True, False]]
    assert statistics.significant_pairs(submissions).tolist() == expected
    assert statistics.significant_pairs(submissions[:1]).tolist() == [[False]]
    assert statistics.significant_pairs([]).shape == (0, 0)


@pytest.mark.parametrize(
    ("better", "ranks"),
    [("higher", [(4, 4), (1, 2), (2, 3), (1, 3)]), ("lower", [(1, 1), (3, 4), (2, 3), (2, 4)])],
)
def test_rank_intervals_by_hand(better: str, ranks: list[tuple[int, int]]) -> None:
    # Submission 0 is worse than all others, submission 2 worse than submission 1; submission 3 is tied with
    # both.
    submissions = [summary([mean, mean + 1]) for mean in (0.0, 7.0, 5.0, 6.0)]
    significant = np.array([[0, 1, 1, 1], [1, 0, 1, 0], [1, 1, 0, 0], [1, 0, 0, 0]], dtype=np.bool_)
    assert statistics.rank_intervals(submissions, significant, better) == ranks


def test_a_smaller_spread_has_the_p_value_of_scipy() -> None:
    rng = np.random.default_rng(0)
    own, others = rng.normal(0, 1, 5).tolist(), [rng.normal(each, 2, 6).tolist() for each in range(3)]
    p_value, spread = statistics.smaller_spread_p(own, others, 0.5)
    pooled = np.mean([np.var(each, ddof=1) for each in others])  # of equal size
    assert spread == pytest.approx(pooled**0.5)
    assert p_value == pytest.approx(stats.f.cdf(np.var(own, ddof=1) / (pooled / 4), 4, 15))


def test_errors_of_anchors_add_to_that_over_runs() -> None:
    # Runs 1, 2, 3: s² = 1, SE² = 1/3 with 2 degrees of freedom. Anchors: SE² 1/6 with 3, and 0.
    found = to_interval(summary([1.0, 2.0, 3.0]), [(1 / 6, 3.0), (0.0, 99.0)])
    df = (1 / 2) ** 2 / ((1 / 3) ** 2 / 2 + (1 / 6) ** 2 / 3)
    assert found.mean == 2.0
    assert found.standard_error == pytest.approx(math.sqrt(1 / 2))
    assert found.df == pytest.approx(df)
    assert found.high == pytest.approx(2.0 + stats.t.ppf(0.975, df) * math.sqrt(1 / 2))


def test_without_errors_of_anchors_the_interval_is_that_over_runs() -> None:
    runs = summary([0.1, 0.2, 0.4])
    assert to_interval(runs, []) == to_interval(runs, [(0.0, 99.0)]) == to_interval(runs)
    assert to_interval(summary([1.0]), [(1.0, 9.0)]) == Interval(1.0)


def test_a_ratio_of_groups_has_the_interval_of_its_linearization() -> None:
    first, second = (1.0, 3.0, 2.0), (2.0, 4.0, 3.0)
    found = statistics.ratio_of_groups([(first, second)])
    residuals = [(a - 2 / 3 * b) / 3 for a, b in zip(first, second, strict=True)]
    assert found.mean == pytest.approx(2 / 3)
    assert found.standard_error == pytest.approx(np.std(residuals, ddof=1) / math.sqrt(3))
    both = statistics.ratio_of_groups([(first, second), ((5.0, 5.0, 5.0), (5.0, 5.0, 5.0))])
    assert both.mean == pytest.approx(7 / 8), "of the means over groups, not the mean of the ratios"


def test_shares_of_the_interquartile_mean_have_its_mean_and_its_standard_error() -> None:
    rng = np.random.default_rng(0)

    def draw() -> list[statistics.Array]:
        return [rng.normal(0, 1, (10, 1)) + rng.normal(0, 0.3, (10, tasks)) for tasks in (5, 2)]

    groups = draw()
    shares = statistics.iqm_shares(groups)
    scores = np.concatenate([each.ravel() for each in groups])
    assert np.mean([np.mean(each) for each in shares]) == pytest.approx(iqm(scores), rel=1e-12)
    means = [iqm(np.concatenate([each.ravel() for each in draw()])) or 0.0 for _ in range(2000)]
    errors = [
        statistics.mean_of_groups([summary(each) for each in statistics.iqm_shares(draw())]).squared_error
        for _ in range(400)
    ]
    assert np.mean(errors) ** 0.5 == pytest.approx(np.std(means), rel=0.1)
