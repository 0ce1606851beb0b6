"""Which runs of a log are scored, and which are identical in every episode."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, stages
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.rules.log import first_identical_runs
from gym_extensions.submissions.submission import SubmittedGroup, scored_group

HOPPER = group("hopper-gravity")


def log(protocol: str, returns: Mapping[int, float]) -> Log:
    """A complete log in which every episode of a run has the given return."""
    tasks = range(len(HOPPER.tasks))
    cells = (sorted(returns), stages(protocol, len(tasks)), tasks, range(EVALUATION_EPISODES))
    run, stage, position, episode = np.array(list(product(*cells))).T
    columns = {"run": run, "stage": stage, "position": position, "episode": episode}
    rows = pd.DataFrame(columns | {"length": 1000, "terminated": False, "success": 0})
    return Log(protocol, HOPPER, rows.assign(**{"return": rows["run"].map(returns)}))


def test_a_run_is_compared_with_the_first_run_of_the_same_measurements() -> None:
    assert first_identical_runs(log("single", {3: 1.0, 5: 2.0, 7: 1.0, 9: 2.0})) == {3: 3, 5: 5, 7: 3, 9: 5}


@pytest.mark.parametrize(
    ("column", "value"),
    [("stage", 2), ("length", 999), ("return", 1.5), ("terminated", True), ("success", 1)],
)
def test_a_difference_in_any_measured_column_of_one_episode_makes_a_run_different(
    column: str, value: float
) -> None:
    runs = log("single", {0: 1.0, 1: 1.0})
    runs.rows.loc[199, column] = value
    assert first_identical_runs(runs) == {0: 0, 1: 1}


def test_the_order_of_rows_does_not_matter() -> None:
    runs = log("single", {0: 1.0, 1: 1.0})
    runs.rows.loc[[0, 199], "return"] = 2.0, 3.0  # the first episode of run 0, the last of run 1
    assert first_identical_runs(runs) == {0: 0, 1: 1}
    runs.rows.loc[[100, 99], "return"] = 2.0, 3.0
    shuffled = runs.rows.sample(frac=1, random_state=0).sort_values("run", kind="stable")
    assert first_identical_runs(replace(runs, rows=shuffled)) == {0: 0, 1: 0}


def test_unequal_runs_of_sequential_and_single_are_noted() -> None:
    logs = {"sequential": log("sequential", {0: 1.0, 1: 2.0, 3: 3.0}), "single": log("single", {0: 5.0})}
    scored = scored_group(SubmittedGroup(HOPPER, logs))
    assert [log.runs for log in scored.logs.values()] == [(0, 1), (0,)]
    missing, unequal = scored.notes
    assert missing.endswith("run 2 is missing; until it is there, not scored: 3.")
    assert unequal.endswith("both have: 0.")


def test_a_log_without_run_0_is_not_scored() -> None:
    scored = scored_group(SubmittedGroup(HOPPER, {"sequential": log("sequential", {1: 1.0, 2: 2.0})}))
    assert scored.logs == {}
    assert scored.notes[0].endswith("run 0 is missing; until it is there, not scored: 1, 2.")


def test_noise_in_the_last_digits_makes_no_other_run() -> None:
    runs = log("single", {0: 12.5, 1: 12.5, 2: -3.0})
    for noise, first in ((4e-12, 0), (1e-5, 0), (1e-3, 1)):
        runs.rows.loc[runs.rows["run"] == 1, "return"] += noise
        assert first_identical_runs(runs) == {0: 0, 1: first, 2: 2}
