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
RUNS = "For example 0, [0, 1] or range(5)."
BAD = [
    ({"runs": "0-4"}, f"runs: Expected an integer or several, got '0-4'. {RUNS}"),
    ({"runs": 1.5}, f"runs: Expected an integer or several, got 1.5. {RUNS}"),
    ({"runs": [0, "1"]}, f"runs: Expected an integer or several, got [0, '1']. {RUNS}"),
    ({"runs": None}, f"runs: Expected an integer or several, got None. {RUNS}"),
    ({"runs": []}, f"runs: Expected an integer or several, got []. {RUNS}"),
    ({"groups": None}, "groups: Expected a group or a list of groups, got None."),
    ({"groups": []}, "groups: Expected a group or a list of groups, got []."),
    ({"protocols": [1]}, "protocols: Expected a name or a list of names, got [1]."),
    ({"budget": 1000}, "There is no budget '1000'. Did you mean '100k'?"),
    ({"num_envs": "8"}, "--num-envs: Expected an integer, got '8'."),
]


@pytest.mark.parametrize(("changed", "message"), BAD, ids=[message[:50] for _, message in BAD])
def test_an_argument_of_another_type_is_rejected(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(BenchError) as error:
        parse_request(**(GOOD | changed))
    assert str(error.value) == message


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
