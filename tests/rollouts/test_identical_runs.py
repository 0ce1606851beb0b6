"""Runs that are identical in every episode: how they are found, and how they are counted as one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, stages
from gym_extensions.rollouts.identical_runs import first_identical_runs, merge_identical_runs, select_runs
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.submission import SubmittedGroup

from .examples import LOG, TOML, edit

HOPPER = group("hopper-gravity")


def log(protocol: str, returns: Mapping[int, float]) -> Log:
    """A complete log in which every episode of a run has the given return."""
    tasks = range(len(HOPPER.tasks))
    cells = (sorted(returns), stages(protocol, len(tasks)), tasks, range(EVALUATION_EPISODES))
    run, stage, position, episode = np.array(list(product(*cells))).T
    return Log(
        path=f"{HOPPER.name}/{protocol}.csv",
        protocol=protocol,
        group=HOPPER,
        runs=tuple(sorted(returns)),
        run=run,
        stage=stage,
        task=[HOPPER.task_ids[index] for index in position],
        position=position,
        episode=episode,
        seed=1000 * position + episode,
        length=np.full(run.size, 1000),
        return_=np.array([returns[number] for number in run.tolist()]),
        terminated=np.zeros(run.size, dtype=np.bool_),
        success=np.zeros(run.size, dtype=np.int8),
        fingerprint=[f"fingerprint of {index}" for index in position],
    )


def merge(**returns: Mapping[int, float]) -> tuple[dict[str, tuple[int, ...]], tuple[str, ...]]:
    """The runs of each log that remain, and the notes."""
    logs = {protocol: log(protocol, values) for protocol, values in returns.items()}
    merged = merge_identical_runs(SubmittedGroup(HOPPER, logs))
    return {protocol: log.runs for protocol, log in merged.logs.items()}, merged.notes


def test_a_run_is_compared_with_the_first_run_of_the_same_measurements() -> None:
    assert first_identical_runs(log("single", {3: 1.0, 5: 2.0, 7: 1.0, 9: 2.0})) == {3: 3, 5: 5, 7: 3, 9: 5}


def test_one_different_episode_makes_a_run_different() -> None:
    runs = log("single", {0: 1.0, 1: 1.0})
    runs.return_[-1] = 1.5
    assert first_identical_runs(runs) == {0: 0, 1: 1}


@pytest.mark.parametrize(
    ("column", "value"),
    [("stage", 2), ("length", 999), ("return_", 1.5), ("terminated", True), ("success", 1)],
)
def test_a_difference_in_any_measured_column_makes_a_run_different(column: str, value: float) -> None:
    runs = log("single", {0: 1.0, 1: 1.0})
    getattr(runs, column)[runs.run == 1] = value
    assert first_identical_runs(runs) == {0: 0, 1: 1}


def test_the_order_of_rows_does_not_matter() -> None:
    runs = log("single", {0: 1.0, 1: 1.0})
    runs.return_[[0, -1]] = 2.0, 3.0  # the first episode of run 0, the last of run 1
    assert first_identical_runs(runs) == {0: 0, 1: 1}
    runs.return_[[100, -101]] = 2.0, 3.0
    runs.episode[100:120] = runs.episode[100:120][::-1]
    runs.return_[[100, 119]] = runs.return_[[119, 100]]
    assert first_identical_runs(runs) == {0: 0, 1: 0}


def test_a_pair_is_merged_if_both_of_its_logs_are_identical() -> None:
    runs, notes = merge(sequential={0: 1.0, 1: 1.0, 2: 2.0}, single={0: 5.0, 1: 5.0, 2: 5.0})
    assert runs == {"sequential": (0, 2), "single": (0, 2)}
    assert notes == ("Runs 0, 1 are identical in every episode and count as one.",)


def test_a_pair_is_not_merged_if_one_of_its_logs_differs() -> None:
    runs, notes = merge(sequential={0: 1.0, 1: 1.0, 2: 2.0}, single={0: 5.0, 1: 6.0, 2: 5.0})
    assert runs == {"sequential": (0, 1, 2), "single": (0, 1, 2)}
    assert notes == ()


def test_each_set_of_identical_runs_is_merged() -> None:
    runs, notes = merge(single={0: 1.0, 1: 2.0, 2: 1.0, 3: 2.0, 4: 1.0})
    assert runs == {"single": (0, 1)}
    assert notes == (
        "Runs 0, 2, 4 are identical in every episode and count as one.",
        "Runs 1, 3 are identical in every episode and count as one.",
    )


def test_joint_runs_are_merged_by_themselves() -> None:
    runs, notes = merge(sequential={0: 1.0, 1: 2.0}, joint={0: 3.0, 1: 3.0})
    assert runs == {"sequential": (0, 1), "joint": (0,)}
    assert notes == ("Joint runs 0, 1 are identical in every episode and count as one.",)


def test_selecting_runs_keeps_their_rows_in_every_column() -> None:
    runs = log("single", {0: 1.0, 1: 2.0, 2: 3.0})
    selected, size = select_runs(runs, {0, 2}), len(HOPPER.tasks) * EVALUATION_EPISODES
    rows = [*range(size), *range(2 * size, 3 * size)]
    assert selected.runs == (0, 2)
    assert selected.run.tolist() == [0] * size + [2] * size
    assert selected.return_.tolist() == [1.0] * size + [3.0] * size
    for name in ("stage", "position", "episode", "seed", "length", "terminated", "success"):
        assert np.array_equal(getattr(selected, name), getattr(runs, name)[rows])
    assert selected.task == [runs.task[row] for row in rows]
    assert selected.fingerprint == [runs.fingerprint[row] for row in rows]


def test_the_reader_merges_the_runs_of_an_agent_without_parameters(submission: Callable[..., Path]) -> None:
    folder = submission(value=lambda protocol, run, stage, position, episode: float(position))
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    submitted = read(folder).groups["hopper-gravity-v0"]
    assert {protocol: log.runs for protocol, log in submitted.logs.items()} == {
        "sequential": (0,),
        "single": (0,),
    }
    assert submitted.notes == ("Runs 0, 1 are identical in every episode and count as one.",)


def test_the_reader_reports_a_pair_with_one_identical_log(submission: Callable[..., Path]) -> None:
    folder = submission(
        value=lambda protocol, run, stage, position, episode: (
            position + (run if protocol == "single" else 0.0)
        )
    )
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    assert [(one.rule, one.where, one.message, one.hint) for one in read(folder).problems] == [
        (
            "identical-runs",
            LOG,
            "Run 1 is identical to run 0 in every episode. In single.csv they differ.",
            "Train each run with its own seed, and write both files from the same agent.",
        )
    ]


def test_the_declared_parameters_count_even_if_the_manifest_has_another_problem(
    submission: Callable[..., Path],
) -> None:
    folder = submission(value=lambda protocol, run, stage, position, episode: float(position))
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    edit("boundaries = ", "luck = true\nboundaries = ", TOML)(folder)
    assert [problem.rule for problem in read(folder).problems] == ["unknown-key"]


def test_sequential_runs_are_merged_beside_a_joint_log_of_other_runs(
    submission: Callable[..., Path],
) -> None:
    folder = submission(
        runs=(0, 1, 2),
        protocols=("sequential", "single", "joint"),
        value=lambda protocol, run, stage, position, episode: float(run if protocol == "joint" else position),
    )
    edit("parameters_last = 100", "parameters_last = 0", TOML)(folder)
    joint = folder / "hopper-gravity" / "joint.csv"
    rows = joint.read_text().splitlines(keepends=True)
    joint.write_text("".join(row for row in rows if row[0] != "2"))
    submitted = read(folder).groups["hopper-gravity-v0"]
    assert {protocol: log.runs for protocol, log in submitted.logs.items()} == {
        "sequential": (0,),
        "single": (0,),
        "joint": (0, 1),
    }


def test_noise_in_the_last_digits_makes_no_other_run() -> None:
    runs = log("single", {0: 12.5, 1: 12.5, 2: -3.0})
    runs.return_[runs.run == 1] *= 1 + 3e-13
    assert first_identical_runs(runs) == {0: 0, 1: 0, 2: 2}
    runs.return_[runs.run == 1] *= 1 + 1e-6  # what replay tolerates
    assert first_identical_runs(runs) == {0: 0, 1: 0, 2: 2}
    runs.return_[runs.run == 1] += 1e-3
    assert first_identical_runs(runs) == {0: 0, 1: 1, 2: 2}
