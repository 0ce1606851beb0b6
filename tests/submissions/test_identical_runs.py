"""Runs that are identical in every episode: how they are found, and how they are counted as one."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, stages
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.submission import SubmittedGroup, first_identical_runs, scored_group

HOPPER = group("hopper-gravity")


def log(protocol: str, returns: Mapping[int, float]) -> Log:
    """A complete log in which every episode of a run has the given return."""
    tasks = range(len(HOPPER.tasks))
    cells = (sorted(returns), stages(protocol, len(tasks)), tasks, range(EVALUATION_EPISODES))
    run, stage, position, episode = np.array(list(product(*cells))).T
    columns = {"run": run, "stage": stage, "position": position, "episode": episode}
    rows = pd.DataFrame(columns | {"length": 1000, "terminated": False, "success": 0})
    return Log(protocol, HOPPER, rows.assign(**{"return": rows["run"].map(returns)}))


def merge(**returns: Mapping[int, float]) -> tuple[dict[str, tuple[int, ...]], tuple[str, ...]]:
    """The runs of each log that remain, and the notes."""
    logs = {protocol: log(protocol, values) for protocol, values in returns.items()}
    merged = scored_group(SubmittedGroup(HOPPER, logs), merge=True)
    return {protocol: log.runs for protocol, log in merged.logs.items()}, merged.notes


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


def test_a_pair_is_merged_if_both_of_its_logs_are_identical() -> None:
    runs, notes = merge(sequential={0: 1.0, 1: 1.0, 2: 2.0}, single={0: 5.0, 1: 5.0, 2: 5.0})
    assert runs == {"sequential": (0, 2), "single": (0, 2)}
    assert notes == ("Runs 0, 1 are identical in every episode and count as one.",)
    runs, notes = merge(sequential={0: 1.0, 1: 1.0, 2: 2.0}, single={0: 5.0, 1: 6.0, 2: 5.0})
    assert (runs, notes) == ({"sequential": (0, 1, 2), "single": (0, 1, 2)}, ())


def test_a_run_without_a_partner_is_compared_by_the_log_that_it_has() -> None:
    runs, notes = merge(sequential={0: 1.0, 1: 2.0, 2: 1.0, 3: 3.0}, single={0: 5.0, 1: 6.0})
    assert runs == {"sequential": (0, 1, 3), "single": (0, 1)}
    identical, unequal = notes
    assert identical == "Runs 0, 2 are identical in every episode and count as one."
    assert unequal.endswith("both have: 0, 1.")


def test_each_set_of_identical_runs_is_merged_and_joint_runs_by_themselves() -> None:
    single, joint = {0: 1.0, 1: 2.0, 2: 1.0, 3: 2.0, 4: 1.0}, {0: 3.0, 1: 3.0}
    runs, notes = merge(single=single, joint=joint)
    assert runs == {"single": (0, 1), "joint": (0,)}
    assert notes == (
        "Runs 0, 2, 4 are identical in every episode and count as one.",
        "Runs 1, 3 are identical in every episode and count as one.",
        "Joint runs 0, 1 are identical in every episode and count as one.",
    )


def test_the_reader_reports_a_pair_with_one_identical_log(make_submission: Callable[..., Path]) -> None:
    folder = make_submission(
        value=lambda protocol, run, stage, position, episode: (
            position + (run if protocol == "single" else 0.0)
        ),
        parameters=0,
    )
    (problem,) = read(folder).problems
    assert (problem.rule, problem.where) == ("identical-runs", f"{HOPPER.name}/sequential/run1.csv")
    assert "In the protocol single they differ" in problem.message


def test_noise_in_the_last_digits_makes_no_other_run() -> None:
    runs = log("single", {0: 12.5, 1: 12.5, 2: -3.0})
    for noise, first in ((4e-12, 0), (1e-5, 0), (1e-3, 1)):
        runs.rows.loc[runs.rows["run"] == 1, "return"] += noise
        assert first_identical_runs(runs) == {0: 0, 1: first, 2: 2}
