"""Policies as data frames: returns, diagnostics, and what these say of forgetting and of networks."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import stats

from gym_extensions import results
from gym_extensions.catalog.groups import group

from ..conftest import Write

Array = NDArray[np.float64]
SUBMISSIONS = Path(__file__).resolve().parents[2] / "submissions"


def test_every_policy_is_a_row_with_its_returns_on_every_task(make_submission: Write) -> None:
    counts = {"sequential": 12, "single": 10, "joint": 2, "cumulative": 2, "descending": 12}
    submission = make_submission(protocols=tuple(counts))
    frame = results.policies(submission)
    assert frame["protocol"].value_counts().to_dict() == counts
    tasks = group("hopper-gravity").task_ids
    scores = results.scores(submission, "hopper-gravity", stage=3).query("run == 1")
    (row,) = frame.query("protocol == 'sequential' and run == 1 and stage == 3").to_dict("records")
    assert row["task"] == tasks[2]
    assert row["returns"] == tuple(scores["return"])
    assert row["scores"] == tuple(scores["normalized"])
    trained = {
        protocol: frame.query("protocol == @protocol and run == 0")["task"].tolist() for protocol in counts
    }
    assert trained["descending"] == ["", *reversed(tasks)]
    assert (trained["single"], trained["joint"], trained["cumulative"]) == ([*tasks], [""], [tasks[-1]])
    single = frame.query("protocol == 'single' and run == 0")["returns"].tolist()
    assert np.isfinite(np.array(single)).tolist() == np.eye(5, dtype=bool).tolist()


def test_a_policy_without_weights_has_no_network(make_submission: Write) -> None:
    frame = results.policies(make_submission(protocols=("sequential",)))
    assert set(frame["parameters"]) == {0}
    assert set(frame["ranks"]) == {()}
    assert not any(frame["kl"].tolist())


def test_a_group_without_published_observations_says_so(make_submission: Write) -> None:
    def steps(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return -2000.0 - 10 * run - episode

    frame = results.policies(make_submission(groups=("nav-image",), protocols=("joint",), value=steps))
    assert frame["parameters"].isna().all()
    assert set(frame["why"]) == {"No observations of its tasks are published."}


@pytest.mark.committed
def test_what_is_stored_is_what_is_computed(tmp_path: Path) -> None:
    stored = SUBMISSIONS / "sac"
    shutil.copytree(stored, tmp_path / "sac", ignore=shutil.ignore_patterns("diagnostics", "halfcheetah-*"))
    again = results.policies(tmp_path / "sac")
    frame = results.policies(stored)
    frame = frame[frame["group"] == "hopper-gravity-v0"]
    for column in ("norms", "ranks", "inactive", "distances", "kl", "drift"):
        for first, second in zip(frame[column], again[column], strict=True):
            assert (first is None) == (second is None)
            assert first is None or first == pytest.approx(second, rel=1e-4)


def made(loss: Array, drift: Array) -> pd.DataFrame:
    """Sequential runs of a group with the scores 1 right after training and 1 − loss at the end."""
    runs, tasks = loss.shape
    rows: list[dict[str, Any]] = []
    for run in range(runs):
        for stage in range(tasks + 2):
            end = stage == tasks + 1
            scores = (*(1 - loss[run]), 1.0) if end else (1.0,) * (tasks + 1)
            changes = {"drift": tuple(drift[run]) if end else (), "distances": (1.0,) * stage}
            ranks = (8.0 - stage, 4.0 + run * stage)
            network = {"parameters": 9, "ranks": ranks, "inactive": (0.5, 0.5), "norms": (1.0, 1.0, 1.0)}
            keys = {"submission": "mine", "group": "g-v0", "protocol": "sequential"}
            rows.append(keys | {"run": run, "stage": stage, "scores": scores} | changes | network)
    return pd.DataFrame(rows)


def test_a_predictor_is_correlated_across_tasks_and_within_each() -> None:
    rng = np.random.default_rng(0)
    level = np.array([0.0, 10.0, 20.0])
    loss, drift = level + rng.uniform(size=(6, 3)), level + rng.uniform(size=(6, 3))
    found: Any = results.forgetting_predictors(made(loss, drift)).set_index(["predictor", "kind"])
    across = stats.spearmanr(loss.ravel(), drift.ravel())[0]
    assert found.loc[("drift", "across"), "mean"] == pytest.approx(across)
    assert found.loc[("drift", "across"), "mean"] > 0.8
    ranks = [np.apply_along_axis(stats.rankdata, 0, each) - 3.5 for each in (loss, drift)]
    expected = (ranks[0] * ranks[1]).sum() / (ranks[0] ** 2).sum()
    row = found.loc[("drift", "within")]
    assert row["mean"] == pytest.approx(expected)
    assert row["low"] < expected < row["high"]
    assert (row["groups"], row["runs"]) == (1, 6)
    assert ("distances", "across") not in found.index, "all distances are equal"


def test_the_interval_of_a_correlation_is_that_of_the_jackknife() -> None:
    rng = np.random.default_rng(1)
    loss, drift = rng.uniform(size=(5, 1)), rng.uniform(size=(5, 1))
    (row,) = results.forgetting_predictors(made(loss, drift)).query("predictor == 'drift'").to_dict("records")
    rho = [stats.spearmanr(np.delete(loss, run), np.delete(drift, run))[0] for run in range(5)]
    pseudo = 5 * row["mean"] - 4 * np.array(rho)
    half = stats.t.ppf(0.975, 4) * pseudo.std(ddof=1) / 5**0.5
    assert row["kind"] == "within"
    assert [row["low"], row["high"]] == pytest.approx([row["mean"] - half, row["mean"] + half])


def test_three_runs_or_one_task_are_too_few_and_one_run_that_decides_has_no_interval() -> None:
    loss = np.arange(6.0).reshape(3, 2)
    assert results.forgetting_predictors(made(loss, loss)).empty
    outlier = np.array([[0.0], [0.0], [0.0], [0.0], [5.0]])
    assert results.forgetting_predictors(made(outlier, np.arange(5.0)[:, None])).empty
    no_task = np.zeros((5, 0))
    assert results.forgetting_predictors(made(no_task, no_task)).empty, "the last task cannot be forgotten"


@pytest.mark.parametrize("function", [results.forgetting_predictors, results.network_changes])
def test_a_run_without_a_stage_is_left_out(function: Callable[[pd.DataFrame], pd.DataFrame]) -> None:
    rng = np.random.default_rng(2)
    frame = made(rng.uniform(size=(6, 2)), rng.uniform(size=(6, 2)))
    lacks_one = frame[(frame["run"] != 0) | (frame["stage"] != 1)]
    pd.testing.assert_frame_equal(function(lacks_one), function(frame[frame["run"] != 0]))
    assert function(frame[frame["stage"] > 0]).empty


def test_a_run_without_a_network_such_as_one_that_failed_is_left_out_of_the_changes() -> None:
    frame = made(np.zeros((3, 2)), np.zeros((3, 2)))
    whole = results.network_changes(frame[frame["run"] != 0])
    for name in ("norms", "ranks", "inactive"):
        frame[name] = frame[name].where(frame["run"] != 0, [()] * len(frame))
    pd.testing.assert_frame_equal(results.network_changes(frame), whole)


def test_the_change_of_a_network_is_from_the_first_task_to_the_last() -> None:
    frame = results.network_changes(made(np.zeros((3, 2)), np.zeros((3, 2))))
    (first, second) = frame[frame["measure"] == "ranks"].to_dict("records")
    assert [first[name] for name in ("untrained", "first", "last", "change")] == [8.0, 7.0, 5.0, -2.0]
    assert (second["layer"], second["change"]) == (2, pytest.approx(2.0)), "runs 0, 1 and 2 gain 0, 2 and 4"
    assert second["low"] == pytest.approx(2.0 - stats.t.ppf(0.975, 2) * 2 / 3**0.5)
