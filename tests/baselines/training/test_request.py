"""Arguments of ``train`` that are out of range or of another type are rejected with a clear message."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines.training.request import parse_request, parse_runs
from gym_extensions.errors import BenchError

GOOD: dict[str, Any] = {
    "groups": "hopper-gravity",
    "protocols": "single",
    "budget": "smoke",
    "runs": 0,
    "num_envs": None,
}
BAD: list[tuple[dict[str, Any], str]] = [
    *(({"runs": value}, "bad-runs") for value in ("0-4", 1.5, [0, "1"], None, [])),
    *(({"groups": value}, "bad-groups") for value in (None, [], [3])),
    ({"protocols": [1]}, "bad-protocols"),
    ({"budget": 1000}, "unknown-budget"),
    ({"num_envs": "8"}, "bad-num-envs"),
]


@pytest.mark.parametrize(("changed", "code"), BAD)
def test_an_argument_of_another_type_is_rejected(changed: dict[str, Any], code: str) -> None:
    with pytest.raises(BenchError) as error:
        parse_request(**(GOOD | changed))
    assert error.value.code == code


@pytest.mark.parametrize("runs", [[2, 0, 1, 0], range(3), np.arange(3), (run for run in range(3))])
def test_runs_are_integers_of_any_type_sorted_and_without_duplicates(runs: Any) -> None:
    assert parse_request(**(GOOD | {"runs": runs})).runs == (0, 1, 2)


def test_a_group_with_and_without_its_version_is_the_same_group() -> None:
    request = parse_request(**(GOOD | {"groups": ["hopper-gravity", "hopper-gravity-v0"]}))
    assert [(group.name, protocol) for group, protocol in request.logs()] == [("hopper-gravity", "single")]


@pytest.mark.parametrize(
    ("text", "expected"), [("0", [0]), ("0,1", [0, 1]), ("0-4", [0, 1, 2, 3, 4]), ("7, 2-3", [7, 2, 3])]
)
def test_runs_on_the_command_line_are_numbers_and_ranges(text: str, expected: list[int]) -> None:
    assert parse_runs(text) == expected


@pytest.mark.parametrize("text", ["", "-1", "1-", "0;1", "1.5"])
def test_any_other_text_is_not_a_list_of_runs(text: str) -> None:
    with pytest.raises(BenchError, match="is not a list of runs"):
        parse_runs(text)
