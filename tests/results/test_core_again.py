"""The core board of the committed entries, computed again from the CSV files, with pandas and scipy."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import stats

from gym_extensions import results
from gym_extensions.envs import group

ROOT = Path(__file__).resolve().parents[2]
REFERENCES = ROOT / "scoring" / "gym_extensions" / "references" / "2.json"
GROUPS = (
    *("hopper-gravity", "walker2d-gravity", "halfcheetah-gravity"),
    *("hopper-wall", "walker2d-wall", "halfcheetah-wall", "hopper-body"),
)
LEVELS = {5: 0.005, 10: 0.01, 20: 0.01, 40: 0.01, 80: 0.01}
"""Of a family at the look at this number of runs (docs/metrics.md)."""
Runs = list[NDArray[np.float64]]
"""In each group one value per run."""


@pytest.fixture(scope="module")
def frames() -> tuple[pd.DataFrame, pd.DataFrame]:
    """The rows of the core and its pairs, as readers get them."""
    return results.core(ROOT / "submissions"), results.core_pairs(ROOT / "submissions")


@functools.cache
def matrices(entry: str, name: str, runs: int) -> NDArray[np.float64]:
    """Normalized mean returns, (runs, stages, tasks), by reading CSV files with pandas."""
    tasks = group(name).task_ids
    anchors = json.loads(REFERENCES.read_text(encoding="utf-8"))["tasks"]
    floors = np.array([anchors[task]["floor"]["mean"] for task in tasks])
    experts = np.array([anchors[task]["expert"]["mean"] for task in tasks])
    found = []
    for run in range(runs):
        log = pd.read_csv(ROOT / "submissions" / entry / name / "sequential" / f"run{run}.csv")
        means = log.pivot_table(values="return", index="stage", columns="task", aggfunc="mean")
        found.append((means[list(tasks)].to_numpy() - floors) / (experts - floors))
    return np.array(found)


def values(entry: str, runs: int) -> Mapping[str, Runs]:
    """Final performance and forgetting of every run, by group."""
    by_group = [matrices(entry, name, runs) for name in GROUPS]
    stages = [np.arange(1, each.shape[1]) for each in by_group]
    learned = [each[:, at, at - 1] for each, at in zip(by_group, stages, strict=True)]
    return {
        "final_performance": [each[:, -1].mean(1) for each in by_group],
        "forgetting": [
            (now[:, :-1] - each[:, -1, :-1]).mean(1) for now, each in zip(learned, by_group, strict=True)
        ],
    }


def pooled(first: Runs, second: Runs, *, paired: bool) -> tuple[float, float, float]:
    """The mean over groups of the differences, its standard error and Satterthwaite's degrees of freedom."""
    if paired:
        sides = [a - b for a, b in zip(first, second, strict=True)]
    else:
        sides = [side for pair in zip(first, second, strict=True) for side in pair]
    errors = np.array([side.var(ddof=1) / len(side) for side in sides]) / len(first) ** 2
    total = float(errors.sum())
    freedom = total**2 / sum(error**2 / (len(side) - 1) for error, side in zip(errors, sides, strict=True))
    mean = np.mean([a.mean() - b.mean() for a, b in zip(first, second, strict=True)])
    return float(mean), total**0.5, freedom


def holm(p_values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Holm's adjusted p values, by the definition."""
    order = np.argsort(p_values)
    scaled = p_values[order] * np.arange(len(p_values), 0, -1)
    adjusted = np.empty_like(p_values)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(scaled))
    return adjusted


def test_scores_are_means_over_the_groups_of_means_over_runs(
    frames: tuple[pd.DataFrame, pd.DataFrame],
) -> None:
    rows = frames[0].query("ranked").set_index("name")
    assert {"trpo", "cloning", "packnet", "online-ewc", "reset"} <= set(rows.index)
    for name, row in rows.iterrows():
        mine = values(str(name), int(row["look"]))
        for metric, by_group in mine.items():
            assert row[metric] == pytest.approx(np.mean([each.mean() for each in by_group]), abs=1e-12)


@pytest.mark.parametrize("metric", ["final_performance", "forgetting"])
def test_pairs_have_the_differences_intervals_and_p_values_of_scipy(
    frames: tuple[pd.DataFrame, pd.DataFrame], metric: str
) -> None:
    rows, pairs = frames[0].query("ranked"), frames[1].query("metric == @metric")
    names = [name for name in rows["name"] if name in {*pairs["first"], *pairs["second"]}]
    assert list(zip(pairs["first"], pairs["second"], strict=True)) == list(combinations(names, 2))
    alone = []
    for row in pairs.to_dict("records"):
        assert row["look"] == rows.set_index("name").loc[[row["first"], row["second"]], "look"].min()
        starts = (
            [matrices(name, each, row["look"])[:, :2] for each in GROUPS]
            for name in (row["first"], row["second"])
        )
        assert row["paired"] == all(map(np.array_equal, *starts))
        first, second = (values(name, row["look"])[metric] for name in (row["first"], row["second"]))
        mean, error, freedom = pooled(first, second, paired=row["paired"])
        low, high = stats.t.interval(1 - LEVELS[row["look"]] / len(pairs), freedom, mean, error)
        assert (row["mean"], row["low"], row["high"]) == pytest.approx((mean, low, high), abs=1e-9)
        alone.append(2 * stats.t.sf(abs(mean / error), freedom) * 0.05 / LEVELS[row["look"]])
    adjusted = holm(np.minimum(1.0, alone))
    assert pairs["p_value"].to_numpy() == pytest.approx(adjusted, rel=1e-6, abs=1e-12)
    assert ((pairs["verdict"] == "separated") == (adjusted <= 0.05)).all()
