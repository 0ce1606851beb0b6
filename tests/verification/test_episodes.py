"""Episodes of stored policies: how much processor time the processes get that run them."""

from pathlib import Path
from typing import Any

import pytest

from gym_extensions.submissions.reader import read
from gym_extensions.verification import episodes, limits, new_seeds
from gym_extensions.verification.logged_run import logged_runs

from ..conftest import refused
from .made_submissions import VALUE, honest


def test_the_hours_are_those_of_all_calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each process uses a tenth of what it may: all of it together is less than the hours."""
    granted = list[int]()

    def answers(_: str, call: Any, allowed: limits.Limits) -> Any:
        granted.append(allowed.cpu_seconds)
        yield from ([0, {"outcomes": [[]]}] for _ in call["runs"][0]["cells"])

    monkeypatch.setattr(episodes, "answers", answers)
    monkeypatch.setattr("os.times", lambda: (sum(granted) / 10, 0.0, 0.0, 0.0, 0.0))
    player = episodes.Player(tmp_path / "store", hours=0.1)
    (run,) = logged_runs(read(honest(runs=1))).values()

    def play(number: int) -> None:
        player.play([run.request(run.new_cells(new_seeds.Draw("digest", VALUE, number)))])

    for number in range(3):
        play(number)
    assert granted == [360, 324, 292]
    monkeypatch.setattr("os.times", lambda: (360.0, 0.0, 0.0, 0.0, 0.0))
    play(2)  # is kept
    with refused(limits.TOO_SLOW, "0.1 hours of processor time were used up"):
        play(3)
