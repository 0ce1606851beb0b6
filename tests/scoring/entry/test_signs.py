"""Signs of trouble in logs: each kind is noticed, and plain logs have none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.rollouts.reader import read
from gym_extensions.scoring.entry.signs import signs

from ..entries import rewrite

Value = Callable[[str, int, int, int, int], float]


def plain(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return 100.0 + run + episode


def nearly_one_run(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    return 100.0 + episode + (run if episode == 0 else 0)


def above_curve(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    # A curve has position 1 and episodes 1 to 12 in `write_submission`; the log has position 3 as well.
    return plain(protocol, run, stage, position, episode) + (50.0 if position == 3 else 0.0)


@pytest.mark.parametrize(
    ("value", "curves", "expected"),
    [
        (plain, 12, ()),
        (
            nearly_one_run,
            0,
            (
                "hopper-gravity-v0, single: 1 of 2 runs share most of their last episodes with an earlier "
                "run.",
            ),
        ),
        (
            above_curve,
            12,
            (
                "hopper-gravity-v0, single: In 2 of 10 cells right after training, the mean return is far "
                "above the training curve.",
            ),
        ),
    ],
)
def test_a_pattern_in_the_returns_is_noticed(
    submission: Callable[..., Path], value: Value, curves: int, expected: tuple[str, ...]
) -> None:
    folder = submission(protocols=("single",), value=value, curves=curves)
    assert signs(read(folder).groups["hopper-gravity-v0"], is_sampled=True) == expected


def test_curves_are_not_compared_with_deterministic_evaluations(submission: Callable[..., Path]) -> None:
    folder = submission(protocols=("single",), value=above_curve, curves=12)
    assert signs(read(folder).groups["hopper-gravity-v0"], is_sampled=False) == ()


def test_episodes_of_one_length_below_the_time_limit_are_noticed(submission: Callable[..., Path]) -> None:
    folder = submission(protocols=("single",))
    rows = (folder / "hopper-gravity" / "single" / "run0.csv").read_text().splitlines(keepends=True)
    first_cell = [row.replace(",1000,", ",999,").replace(",false,", ",true,") for row in rows[1:21]]
    rewrite(folder, "hopper-gravity/single/run0", "".join([rows[0], *first_cell, *rows[21:]]))
    entry = read(folder)
    assert entry.problems == ()
    assert signs(entry.groups["hopper-gravity-v0"], is_sampled=False) == (
        "hopper-gravity-v0, single: In 1 of 10 cells, all 20 episodes have the same length, which is below "
        "the time limit.",
    )
