"""Duplicates: entries that share most of their episodes, whatever was changed in the copy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.rollouts.reader import read
from gym_extensions.scoring.leaderboard.duplicates import duplicate_entries
from gym_extensions.scoring.scorecard.sketches import SIZE, Sketch, episode_sketches, is_common

GROUP = "hopper-gravity-v0"
RUNS = (0, 1, 2)

Value = Callable[[str, int, int, int, int], float]


def sketch(*numbers: int) -> Sketch:
    return tuple(f"{number:08x}" for number in numbers)


def honest(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    """Returns without a common episode between runs."""
    return 7.0 * stage + 100.0 * run + 31.0 * position + episode / 8 + 0.123456


@pytest.fixture
def sketches(submission: Callable[..., Path]) -> Callable[..., tuple[Sketch, ...]]:
    def make(name: str, value: Value = honest, runs: tuple[int, ...] = RUNS) -> tuple[Sketch, ...]:
        folder = submission(name=name, value=value, runs=runs, protocols=("sequential",))
        return episode_sketches(read(folder).groups[GROUP].logs["sequential"])

    return make


def noise(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return honest(protocol, run, stage, position, episode) * (1 + 3e-13)


def other_runs(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return honest(protocol, 2 - run, stage, position, episode)


def a_fifth_invented(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return honest(protocol, run, stage, position, episode) + (50.0 if episode % 5 == 0 else 0.0)


def one_run_invented(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return honest(protocol, run, stage, position, episode) + (55.0 if run == 1 else 0.0)


def other_early_stages(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return honest(protocol, run, stage, position, episode) + (1.5 if stage < 5 else 0.0)


@pytest.mark.parametrize("copy", [noise, other_runs, a_fifth_invented, one_run_invented, other_early_stages])
def test_a_changed_copy_is_recognized(sketches: Callable[..., tuple[Sketch, ...]], copy: Value) -> None:
    entries = {"copy": sketches("copy", copy), "original": sketches("original")}
    assert duplicate_entries(entries) == {"original": "copy"}


def test_a_copy_with_further_runs_is_recognized(sketches: Callable[..., tuple[Sketch, ...]]) -> None:
    entries = {"copy": sketches("copy", runs=tuple(range(8))), "original": sketches("original")}
    assert duplicate_entries(entries) == {"original": "copy"}


def test_in_navigation_agents_that_stand_still_are_other_entries_if_their_traces_differ(
    submission: Callable[..., Path],
) -> None:
    folder = submission(value=lambda *_: -1000.0, runs=RUNS, protocols=("sequential",))
    log = read(folder).groups[GROUP].logs["sequential"]
    rows = len(log.run)

    def traced(first: int) -> tuple[Sketch, ...]:
        traces = [f"{first + number:032x}" for number in range(rows)]
        return episode_sketches(replace(log, group=GROUPS["nav-state"], trace=traces))

    assert duplicate_entries({"still": traced(0), "other": traced(rows)}) == {}
    assert duplicate_entries({"still": traced(0), "copy": traced(0)}) == {"copy": "still"}


def shifted(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return honest(protocol, run, stage, position, episode) + 0.05


def same_early_stages(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return honest(protocol, run, stage, position, episode) + (1.5 if stage == 5 else 0.0)


@pytest.mark.parametrize("other", [shifted, same_early_stages])
def test_other_episodes_after_the_last_stage_are_another_entry(
    sketches: Callable[..., tuple[Sketch, ...]], other: Value
) -> None:
    """Methods that differ from the second task on share the episodes of the first stages."""
    assert duplicate_entries({"a": sketches("a"), "b": sketches("b", other)}) == {}


def test_a_sketch_has_sixteen_sorted_digests(sketches: Callable[..., tuple[Sketch, ...]]) -> None:
    made = sketches("a")
    assert [len(run) for run in made] == [SIZE] * len(RUNS)
    assert all(list(run) == sorted(run) for run in made)


@pytest.mark.parametrize(("count", "expected"), [(16, True), (8, True), (7, False), (0, False)])
def test_half_of_the_smallest_digests_of_both_are_common(count: int, expected: bool) -> None:
    first = sketch(*range(16))
    second = sketch(*sorted([*range(count), *range(100, 116 - count)]))
    assert is_common(first, second) == expected


def test_each_duplicate_names_the_first_of_the_mapping() -> None:
    same = [sketch(1, 2)]
    assert duplicate_entries({"c": same, "a": same, "b": same}) == {"a": "c", "b": "c"}


@pytest.mark.parametrize("names", [("a", "b"), ("b", "a")])
def test_a_copy_of_two_entries_names_the_first(names: tuple[str, str]) -> None:
    entries = dict(zip(names, ([sketch(3)], [sketch(1)]), strict=True))
    copy = [sketch(1), sketch(3)]
    assert duplicate_entries(entries | {"copy": copy}) == {"copy": names[0]}


def test_two_groups_of_duplicates_stay_apart() -> None:
    first, second = [sketch(1)], [sketch(2)]
    entries = {"a": first, "b": second, "c": first, "d": second}
    assert duplicate_entries(entries) == {"c": "a", "d": "b"}


def test_entries_without_runs_are_not_duplicates() -> None:
    assert duplicate_entries({"a": [], "b": [], "c": [()], "d": [()]}) == {}
