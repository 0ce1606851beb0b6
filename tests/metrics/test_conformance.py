"""The published conformance kit: matrices worked by hand, and what every metric makes of them."""

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from statistics import fmean
from typing import Any

import pytest

from gym_extensions import metrics
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import IN_ORDER
from gym_extensions.catalog.tasks import Task
from gym_extensions.metrics import statistics
from gym_extensions.metrics.formulas import METRICS, area, iqm, profile
from gym_extensions.metrics.order_effects import order_effects
from gym_extensions.metrics.values import NO_TERM, TOO_FEW_POINTS, MetricValue
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.submission.normalization import GroupReturns, normalized_runs
from gym_extensions.scoring.submission.reported_tables import paper_table
from gym_extensions.scoring.submission.scorer import metric_values

KIT = Path(str(metrics.__file__)).parent / "conformance"
EXACT = 1e-12


def kit(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((KIT / f"{name}.json").read_text(encoding="utf-8"))
    assert found["format"] == 1
    return found


def named(case: dict[str, Any]) -> str:
    return str(case["name"])


def cells(nested: Any, axes: int) -> Any:
    """The nested lists with the same number of episodes in every cell, which is below so many axes."""

    def counts(part: Any, level: int) -> list[int]:
        if level == 0:
            return [len(part) if isinstance(part, list) else 1]
        return [count for inner in part for count in counts(inner, level - 1)]

    def fill(part: Any, level: int) -> Any:
        if level:
            return [fill(inner, level - 1) for inner in part]
        return part if isinstance(part, list) else [part] * most

    most = max(counts(nested, axes))
    return fill(nested, axes)


def results(case: dict[str, Any]) -> GroupReturns:
    returns = {
        protocol: cells(case[protocol], 3)
        if protocol in IN_ORDER
        else [[run] for run in cells(case[protocol], 2)]
        for protocol in METRICS
        if case.get(protocol) is not None
    }
    tasks = len(next(iter(returns.values()))[0][0])
    group = TaskGroup("kit", tuple(Task(f"Task{j}", "Hopper") for j in range(1, tasks + 1)))
    return GroupReturns(group, 1, {name: tuple(range(len(runs))) for name, runs in returns.items()}, returns)


def references(case: dict[str, Any], group: TaskGroup) -> References:
    heights = zip(group.task_ids, case["floor"], case["expert"], strict=True)
    tasks = {
        task: Reference(Floor(floor), None if expert is None else Expert(expert))
        for task, floor, expert in heights
    }
    return References("kit", tasks)


OWN_FILE = [protocol for protocol in METRICS if protocol not in ("descending", "balanced")]
"""The others have the metrics of sequential, with another order of training: order.json."""


@pytest.mark.parametrize("protocol", list(METRICS))
def test_metrics_of_runs(protocol: str) -> None:
    cases = kit(protocol if protocol in OWN_FILE else "order")["cases"]
    for case in (each for each in cases if each.get("protocol", protocol) == protocol):
        found = results(case)
        known = references(case, found.group)
        got = metric_values(found, known, protocol, normalized_runs(found, known, protocol))
        for name, expected in case["expected"].items():
            if expected is None:
                assert got[name].mean is None, (case["name"], name)
                assert got[name].why, (case["name"], name)
            else:
                assert got[name].runs == pytest.approx(expected, abs=EXACT), (case["name"], name)


def test_effects_of_position_and_task() -> None:
    (case,) = [case for case in kit("order")["cases"] if "effects" in case]
    found = results(case)
    effects = order_effects(normalized_runs(found, references(case, found.group), "balanced"))
    assert effects.keys() == case["effects"].keys()
    for name, expected in case["effects"].items():
        got = {
            "position": [each.mean for each in effects[name].position],
            "task": [each.mean for each in effects[name].task],
            "shares": {share: value.mean for share, value in effects[name].shares.items()},
        }
        for kind, values in expected.items():
            assert got[kind] == pytest.approx(values, abs=EXACT), (name, kind)


@pytest.mark.parametrize("protocol", OWN_FILE)
def test_every_metric_has_a_case(protocol: str) -> None:
    files = [protocol, "transfer"] if protocol == "sequential" else [protocol]
    inside = {name for file in files for case in kit(file)["cases"] for name in case["expected"]}
    elsewhere = {"joint_gap", "practice", "transfer_at_equal_practice"}  # the two tests below
    assert {metric.name for metric in METRICS[protocol]} - elsewhere <= inside


def test_practice_and_transfer_at_equal_practice() -> None:
    (case,) = [case for case in kit("cumulative")["cases"] if "practice" in case]
    found = results(case)
    known = references(case, found.group)
    got = metric_values(found, known, "sequential", normalized_runs(found, known, "sequential"))
    for name in ("practice", "transfer_at_equal_practice"):
        assert got[name].mean == pytest.approx(case[name], abs=EXACT)
        assert got[name].low is not None
        assert fmean(got[name].runs) == got[name].mean


def test_the_joint_gap() -> None:
    (case,) = [case for case in kit("joint")["cases"] if "joint_gap" in case]
    found = results(case)
    known = references(case, found.group)
    gap = metric_values(found, known, "sequential", normalized_runs(found, known, "sequential"))["joint_gap"]
    assert gap.mean == pytest.approx(case["joint_gap"], abs=EXACT)
    assert gap == MetricValue.of(statistics.difference((1.0, 0.75, 0.75), (0.5, 0.25)))


@pytest.mark.parametrize("case", kit("curves")["cases"], ids=named)
def test_areas_under_training_curves(case: dict[str, Any]) -> None:
    points = [(float(step), float(value)) for step, value in case["points"]]
    steps, values = [list(column) for column in zip(*points, strict=True)]
    assert area(steps, values, case["D"]) == (
        None if case["area"] is None else pytest.approx(case["area"], abs=EXACT)
    )


@pytest.mark.parametrize("case", kit("transfer")["cases"], ids=named)
def test_forward_transfer_auc(case: dict[str, Any]) -> None:
    runs, tasks = len(case["sequential"]), len(case["floor"])
    blank = {"sequential": [[[0] * tasks] * (tasks + 1)] * runs, "single": [[0] * tasks] * runs}
    without = results(blank)
    curves = {
        (protocol, run, task): ([step for step, _ in points], [float(value) for _, value in points])
        for protocol in ("sequential", "single")
        for run, row in enumerate(case[protocol])
        for task, points in zip(without.group.task_ids, row, strict=True)
    }
    found = dataclasses.replace(without, steps=case["D"], curves=curves)
    known = references(case, found.group)
    got = metric_values(found, known, "sequential", normalized_runs(found, known, "sequential"))
    ((name, expected),) = case["expected"].items()
    assert got[name].runs == (() if expected is None else pytest.approx(expected, abs=EXACT))
    assert (got[name].mean is None) is (expected is None)
    if expected is None:
        enough = all(len(points) >= 10 for _, points in curves.values())
        assert got[name].why == (NO_TERM if enough else TOO_FEW_POINTS)


INTERVALS: dict[str, Callable[[dict[str, Any]], statistics.Interval]] = {
    "mean": lambda case: statistics.interval(case["values"]),
    "suite": lambda case: statistics.to_interval(
        statistics.mean_of_groups([statistics.summary(values) for values in case["groups"]])
    ),
    "difference": lambda case: statistics.difference(case["first"], case["second"]),
}


@pytest.mark.parametrize("kind", INTERVALS)
def test_intervals_of_a_mean_a_suite_and_a_difference(kind: str) -> None:
    for case in kit("intervals")[kind]:
        found = INTERVALS[kind](case)
        for key in ("mean", "low", "high"):
            expected = None if case[key] is None else pytest.approx(case[key], abs=1e-10)
            assert getattr(found, key) == expected, (case["name"], key)


@pytest.mark.parametrize("case", kit("distribution")["cases"], ids=named)
def test_interquartile_mean_and_performance_profile(case: dict[str, Any]) -> None:
    assert iqm(case["values"]) == pytest.approx(case["iqm"], abs=EXACT)
    found = profile(case["values"])
    assert found is not None
    curve = dict(found.points)
    assert [curve[tau] for tau, _ in case["profile"]] == pytest.approx(
        [f for _, f in case["profile"]], abs=EXACT
    )


@pytest.mark.parametrize("case", kit("table")["cases"], ids=named)
def test_the_papers_table(case: dict[str, Any]) -> None:
    rows, total = paper_table(results(case))
    assert len(rows) == len(case["rows"])
    assert [row.task for row in rows] == [f"gym_extensions/Task{j}-v0" for j in range(1, len(rows) + 1)]
    assert [row.printed_task for row in rows] == [""] * len(rows)
    for row, expected in zip([*rows, total], [*case["rows"], case["total"]], strict=True):
        for column, cell in expected.items():
            found = row.cell(column)
            mean_and_std = None if found is None else {"mean": found.mean, "std": found.std}
            assert mean_and_std == (None if cell is None else pytest.approx(cell, abs=EXACT)), column


@pytest.mark.parametrize("case", kit("ranks")["cases"], ids=named)
def test_rank_intervals(case: dict[str, Any]) -> None:
    submissions = [statistics.summary(values) for values in case["submissions"]]
    ranks = statistics.rank_intervals(submissions, statistics.significant_pairs(submissions), case["better"])
    assert [list(first_and_last) for first_and_last in ranks] == case["ranks"]
