"""What a program asks of ``train`` in a wrong kind of value is told in a sentence, not a traceback."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.training.request import checked
from gym_extensions.errors import BenchError

GOOD = {"groups": "hopper-gravity", "protocols": "single", "budget": "smoke", "runs": 0, "lanes": None}
RUNS = "Give a whole number or several, as in 0, [0, 1] or range(5)."
NAMES = "Give a name, or a list of names."
BAD = [
    ({"runs": "0-4"}, f"runs: '0-4' is no list of runs. {RUNS}"),
    ({"runs": 1.5}, f"runs: 1.5 is no list of runs. {RUNS}"),
    ({"runs": [0, "1"]}, f"runs: [0, '1'] is no list of runs. {RUNS}"),
    ({"runs": None}, f"runs: None is no list of runs. {RUNS}"),
    ({"runs": []}, f"runs: [] is no list of runs. {RUNS}"),
    ({"groups": None}, f"groups: None names nothing. {NAMES}"),
    ({"groups": []}, f"groups: [] names nothing. {NAMES}"),
    ({"protocols": [1]}, f"protocols: [1] names nothing. {NAMES}"),
    ({"budget": 1000}, "There is no budget '1000'. Did you mean '100k'?"),
    ({"lanes": "8"}, "--lanes: '8' is no number of lanes. Give a whole number."),
]


@pytest.mark.parametrize(("changed", "message"), BAD, ids=[message[:30] for _, message in BAD])
def test_a_value_of_a_wrong_kind_is_told(changed, message):
    with pytest.raises(BenchError) as told:
        checked(**(GOOD | changed))
    assert str(told.value) == message


@pytest.mark.parametrize("runs", [[2, 0, 1, 0], range(3), np.arange(3), (run for run in range(3))])
def test_runs_are_whole_numbers_of_any_kind_in_order_and_once(runs):
    assert checked(**(GOOD | {"runs": runs})).runs == (0, 1, 2)
