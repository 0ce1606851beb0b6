"""Wrong arguments of ``train`` on reports and evaluation during training."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import train
from gym_extensions.errors import BenchError

from .conftest import QUICK_GROUP, SHORT_GROUP, digests

BAD: list[tuple[dict[str, Any], str]] = [
    ({"log": "tensorbord"}, "log: There is no log 'tensorbord'. Did you mean 'tensorboard'?"),
    ({"log": ["csv", 3]}, "log: There is no log 3. Choose one of: csv, tensorboard."),
    ({"log": 3}, "log: There is no log 3. Choose one of: csv, tensorboard."),
    (
        {"callback": "print"},
        "callback: Expected a function, got a value of type str. "
        "Pass a function with one argument, the event.",
    ),
    ({"evaluate_every": 0}, "--evaluate-every: 0 is too small. Use at least 1."),
    ({"evaluate_every": 2.5}, "--evaluate-every: Expected an integer, got 2.5."),
    ({"evaluate_every": True}, "--evaluate-every: Expected an integer, got True."),
    ({"num_threads": 0}, "--num-threads: 0 is too small. Use at least 1."),
    ({"num_threads": "2"}, "--num-threads: Expected an integer, got '2'."),
    ({"evaluate_episodes": 0}, "--evaluate-episodes: 0 is too small. Use at least 1."),
    (
        {"evaluate_episodes": 21},
        "--evaluate-episodes: 21 is too large. Use at most 20, the episodes that have a prescribed seed.",
    ),
]


@pytest.mark.parametrize(("arguments", "message"), BAD, ids=[message[:40] for _, message in BAD])
def test_a_wrong_argument_is_rejected_before_training(
    arguments: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(BenchError) as error:
        train("zero", SHORT_GROUP, "single", "smoke", 0, out=tmp_path / "mine", **arguments)
    assert str(error.value) == message
    assert not (tmp_path / "mine").exists()


def test_logs_and_policies_do_not_depend_on_the_number_of_threads(tmp_path: Path) -> None:
    for num_threads in (1, 2):
        folder = tmp_path / f"{num_threads}-threads"
        train("trpo", QUICK_GROUP, "sequential", "smoke", 0, out=folder, num_threads=num_threads)
    one, two = map(digests, sorted(tmp_path.iterdir()))
    assert {Path(name).suffix for name in one} >= {".csv", ".npz"}
    assert one == two
