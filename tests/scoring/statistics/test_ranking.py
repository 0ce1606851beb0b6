"""Ranks: which entries Welch's test tells apart under Holm's correction, and how many runs would."""

from __future__ import annotations

import math
import random
from itertools import combinations

import numpy as np
import pytest
from scipy import stats

from gym_extensions.scoring.statistics.intervals import Summary, less, summary, summary_of
from gym_extensions.scoring.statistics.ranking import LEVEL, different, holm, rank_intervals, runs_to_separate
from gym_extensions.scoring.statistics.student_t import two_sided_p
from gym_extensions.scoring.statistics.welch import CLOSE, HOPELESS, NO_PAIR, pairs


def rejected(values: list[float]) -> list[bool]:
    found: list[bool] = holm(np.array(values), values.__getitem__).tolist()
    return found


def test_holms_procedure_by_hand() -> None:
    # .01 ≤ .05/4, .013 ≤ .05/3, .03 > .05/2: it stops there, although .04 ≤ .05.
    assert rejected([0.03, 0.01, 0.04, 0.013]) == [False, True, False, True]
    assert rejected([0.05]) == [True]
    assert rejected([0.051]) == [False]
    assert rejected([]) == []


def _adjusted(values: list[float]) -> list[float]:
    """Holm's adjusted p values, written down from their definition."""
    order = sorted(values)
    return [
        max(min(1.0, (len(values) - place) * one) for place, one in enumerate(order) if one <= value)
        for value in values
    ]


def test_holms_procedure_rejects_where_the_adjusted_p_value_is_at_most_the_level() -> None:
    rng = random.Random(3)
    for _ in range(200):
        values = [rng.random() ** 4 for _ in range(rng.randint(1, 12))]
        assert rejected(values) == [adjusted <= 0.05 for adjusted in _adjusted(values)]


def test_a_p_value_near_its_limit_is_looked_up_and_no_other() -> None:
    # Two hypotheses: the limits are .025 and .05.
    asked: list[int] = []

    def exact(place: int) -> float:
        asked.append(place)
        return 0.025 if place == 1 else math.nan

    assert holm(np.array([0.9, 0.025 * (1 + CLOSE / 2)]), exact).tolist() == [False, True]
    assert asked == [1]
    assert holm(np.array([0.9, 0.025 * (1 + CLOSE * 2)]), exact).tolist() == [False, False]
    assert holm(np.array([0.9, 0.025 * (1 - CLOSE * 2)]), exact).tolist() == [False, True]
    assert asked == [1]


def test_a_small_t_is_not_looked_up_and_would_not_be_significant() -> None:
    assert two_sided_p(HOPELESS, 1e6) > LEVEL
    found = pairs([summary([0, 1, 2]), summary([0.1, 1.1, 2.1])])
    assert found.exact(0, 1) == found.quick(LEVEL)[0, 1] == 1.0


def board(rng: random.Random, entries: int, spread: float) -> list[Summary]:
    """Entries of two to nine runs whose true means lie apart by about ``spread`` deviations."""
    return [
        summary([rng.gauss(rng.gauss(0, spread), rng.uniform(0.1, 2)) for _ in range(rng.randint(2, 9))])
        for _ in range(entries)
    ]


@pytest.mark.parametrize("spread", [0.0, 3.0, 30.0, 3000.0])
def test_quick_p_values_are_far_better_than_what_counts_as_close(spread: float) -> None:
    found = pairs(board(random.Random(1), 150, spread))
    quick, upper = found.quick(LEVEL), np.triu_indices(150, 1)
    exact = np.array([found.exact(a, b) for a, b in combinations(range(150), 2)])
    asked = quick[upper] < 1
    assert (np.abs(quick[upper] - exact)[asked] <= CLOSE / 10 * exact[asked]).all()
    # Whatever was not asked for is above the last limit that Holm's procedure can come to.
    assert (exact[~asked] > LEVEL / (asked.size - asked.sum())).all()
    assert (quick[np.tril_indices(150)] == NO_PAIR).all()


@pytest.mark.parametrize("most", [400.0, 2000.0, 20_000.0])
def test_quick_p_values_are_as_good_where_one_entry_has_two_runs_and_another_very_many(most: float) -> None:
    # Degrees of freedom from 1 on in geometric progression; means about six standard errors apart.
    rng = random.Random(6)
    freedoms = [most ** (place / 99) for place in range(100)]
    entries = [Summary(rng.gauss(0, 6), rng.uniform(0.1, 2), freedom, 2, 0, 0) for freedom in freedoms]
    found = pairs(entries)
    quick, both = found.quick(LEVEL), list(combinations(range(100), 2))
    exact = {(a, b): found.exact(a, b) for a, b in both if quick[a, b] < 1}
    seen = {pair: p for pair, p in exact.items() if p >= 1e-12}
    assert max(abs(quick[pair] - p) / p for pair, p in seen.items()) <= CLOSE / 10
    pooled = [float(found.welch(*pair)[1]) for pair in seen]
    assert (min(pooled) < 2, max(pooled) > most) == (True, True)
    assert (min(seen.values()) < 1e-11, max(seen.values()) > 0.03) == (True, True)


@pytest.mark.parametrize("spread", [0.0, 1.0, 3.0, 10.0, 30.0])
def test_all_pairs_at_once_are_told_apart_as_one_by_one(spread: float) -> None:
    rng = random.Random(2)
    for entries in (2, 3, 10, 40):
        rows = board(rng, entries, spread)
        both = list(combinations(range(entries), 2))
        apart = [adjusted <= LEVEL for adjusted in _adjusted([pairs(rows).exact(a, b) for a, b in both])]
        found = different(rows)
        assert [bool(found[pair]) for pair in both] == apart
        assert (found == found.T).all()
        assert not found.diagonal().any()


def test_entries_without_variance_differ_if_their_means_do() -> None:
    entries = [summary([1.0] * 5), summary([1.0] * 5), summary([2.0] * 5)]
    assert different(entries).tolist() == [[False, False, True], [False, False, True], [True, True, False]]
    assert [float(pairs(entries).welch(a, b)[0]) for a, b in combinations(range(3), 2)] == [
        0,
        -math.inf,
        -math.inf,
    ]


def test_one_entry_has_rank_one() -> None:
    entries = [summary([1.0, 2.0])]
    assert rank_intervals(entries, different(entries), "higher") == [(1, 1)]


def test_ranks_do_not_depend_on_the_order_of_entries() -> None:
    rng = random.Random(5)
    entries = [summary([rng.gauss(place, 1) for _ in range(5)]) for place in range(8)]
    ranks = rank_intervals(entries, different(entries), "higher")
    turned = rank_intervals(entries[::-1], different(entries[::-1]), "higher")
    assert turned == ranks[::-1]


def entry(mean: float, deviation: float, groups: int = 1, runs: int = 5) -> Summary:
    """An entry with that mean and that deviation over runs, of its mean over so many groups."""
    places = [place - (runs - 1) / 2 for place in range(runs)]
    unit = math.sqrt(sum(place * place for place in places) / (runs - 1))
    group = summary([mean + deviation * math.sqrt(groups) * place / unit for place in places])
    return group if groups == 1 else summary_of([group] * groups)


def needed(gap: float, first: float, second: float, entries: int, groups: int = 1) -> int | None:
    """The runs that separate two entries of these deviations, on a board of so many entries."""
    return runs_to_separate(less(entry(gap, first, groups), entry(0, second, groups)), entries)


@pytest.mark.parametrize(("runs", "gap"), [(5, 4.5), (10, 2.25)])
def test_five_runs_separate_four_and_a_half_deviations_on_a_board_of_ten(runs: int, gap: float) -> None:
    assert needed(gap, 1.0, 1.0, 10) == runs


def test_runs_to_separate_in_dumb_cases() -> None:
    assert needed(0.0, 1.0, 1.0, 2) is None
    assert needed(0.01, 1.0, 1.0, 2) is None
    assert needed(1.0, 0.0, 0.0, 2) == 2
    assert needed(1.0, 1.0, 1.0, 2) == 17  # as any table of sample sizes has it: d = 1, 80 %, 5 %


def test_runs_to_separate_has_the_power_that_it_names() -> None:
    rng = random.Random(11)
    runs = needed(2.0, 1.0, 0.5, 2)
    assert runs is not None
    seen = sum(
        different(
            [
                summary([rng.gauss(2, 1) for _ in range(runs)]),
                summary([rng.gauss(0, 0.5) for _ in range(runs)]),
            ]
        )[0, 1]
        for _ in range(2000)
    )
    assert seen / 2000 >= 0.78
    assert not reaches(runs - 1, 2, [1.0], [0.5], 2)


def reaches(runs: int, gap: float, first: list[float], second: list[float], entries: int) -> bool:
    """The definition: the power of Welch's test, so many runs of every group, by scipy's noncentral t.

    ``first`` and ``second`` are each entry's deviations over runs, one a group.
    """
    count = len(first)
    squares = [one * one / runs / count**2 for one in (*first, *second)]
    freedom = (runs - 1) * sum(squares) ** 2 / sum(square * square for square in squares)
    limit = stats.t.isf(LEVEL / (entries * (entries - 1) / 2) / 2, freedom)
    return bool(stats.nct.sf(limit, freedom, gap / math.sqrt(sum(squares))) >= 0.8)


def test_runs_to_separate_is_the_least_number_that_has_the_power() -> None:
    rng = random.Random(13)
    for _ in range(12):
        gap, first, second, entries = (
            rng.uniform(0.5, 6),
            rng.uniform(0.1, 2),
            rng.uniform(0.1, 2),
            rng.randint(2, 30),
        )
        expected = (runs for runs in range(2, 101) if reaches(runs, gap, [first], [second], entries))
        assert needed(gap, first, second, entries) == next(expected, None)


@pytest.mark.parametrize(("entries", "groups", "runs"), [(10, 1, 25), (10, 4, 23), (2, 1, 12), (2, 4, 11)])
def test_on_a_suite_every_group_brings_degrees_of_freedom(entries: int, groups: int, runs: int) -> None:
    # One and a quarter deviations apart; four groups have 8 (n − 1) degrees of freedom, one has 2 (n − 1).
    assert needed(1.25, 1.0, 1.0, entries, groups) == runs
    same = [math.sqrt(groups)] * groups
    assert [reaches(n, 1.25, same, same, entries) for n in (runs - 1, runs)] == [False, True]


def test_so_it_is_where_groups_differ_in_deviations_and_in_runs() -> None:
    rng = random.Random(17)
    for _ in range(12):
        count, entries, gap = rng.randint(2, 6), rng.randint(2, 20), rng.uniform(0.3, 2)
        first, second = ([rng.uniform(0.1, 2) for _ in range(count)] for _ in range(2))
        upper, lower = (
            summary_of([entry(mean, one, runs=rng.randint(5, 12)) for one in deviations])
            for mean, deviations in ((gap, first), (0.0, second))
        )
        expected = (runs for runs in range(2, 101) if reaches(runs, gap, first, second, entries))
        assert runs_to_separate(less(upper, lower), entries) == next(expected, None)
