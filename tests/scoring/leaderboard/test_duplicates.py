"""Duplicates: entries whose every metric is the same in every run, digit for digit."""

from __future__ import annotations

from gym_extensions.scoring.leaderboard.duplicates import duplicate_entries
from gym_extensions.scoring.metrics.value import MetricValue


def entry(**runs: tuple[float, ...]) -> dict[str, MetricValue]:
    """Metrics with these values per run."""
    return {name: MetricValue(runs=values) for name, values in runs.items()}


def test_each_duplicate_names_the_first_of_the_mapping() -> None:
    same = entry(final=(0.1, 0.2))
    assert duplicate_entries({"c": same, "a": same, "b": same}) == {"a": "c", "b": "c"}


def test_the_first_of_a_pair_is_not_a_duplicate() -> None:
    same = entry(final=(0.1,))
    assert duplicate_entries({"b": same, "a": same, "other": entry(final=(0.2,))}) == {"a": "b"}


def test_one_different_run_of_one_metric_is_enough_to_differ() -> None:
    first = entry(final=(0.1, 0.2), forgetting=(0.0, 0.0))
    second = entry(final=(0.1, 0.2), forgetting=(0.0, 1e-17))
    assert duplicate_entries({"a": first, "b": second}) == {}


def test_the_order_of_runs_and_of_metrics() -> None:
    first = entry(final=(0.1, 0.2), forgetting=(0.3, 0.4))
    swapped_metrics = entry(forgetting=(0.3, 0.4), final=(0.1, 0.2))
    swapped_runs = entry(final=(0.2, 0.1), forgetting=(0.4, 0.3))
    duplicates = duplicate_entries({"a": first, "b": swapped_metrics, "c": swapped_runs})
    assert duplicates == {"b": "a"}


def test_values_under_different_names_are_not_the_same() -> None:
    entries = {"a": entry(final=(0.1,), forgetting=()), "b": entry(final=(), forgetting=(0.1,))}
    assert duplicate_entries(entries) == {}


def test_entries_without_a_value_in_any_run_are_not_duplicates() -> None:
    nothing = entry(final=(), forgetting=())
    assert duplicate_entries({"a": nothing, "b": nothing}) == {}


def test_a_value_in_one_metric_is_enough_to_be_a_duplicate() -> None:
    partly = entry(final=(0.5,), forgetting=())
    assert duplicate_entries({"a": partly, "b": partly}) == {"b": "a"}


def test_two_groups_of_duplicates_stay_apart() -> None:
    first, second = entry(final=(0.1,)), entry(final=(0.2,))
    entries = {"a": first, "b": second, "c": first, "d": second}
    assert duplicate_entries(entries) == {"c": "a", "d": "b"}
