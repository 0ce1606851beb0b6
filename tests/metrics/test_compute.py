"""Metrics of a matrix from anywhere: the conformance kit through the public function, and wrong input."""

from typing import Any

import numpy as np
import pytest

from gym_extensions import metrics
from gym_extensions.errors import BenchError
from gym_extensions.metrics.formulas import TABLE

from ..conftest import refused
from .test_conformance import cells, kit, named

R = [[0.0, 0.1, 0.2], [0.6, 0.3, 0.2], [0.8, 0.7, 0.4], [0.5, 0.4, 0.9]]


def means(nested: Any, axes: int) -> Any:
    """The nested lists with a number for each list of episodes below that many axes."""
    if axes:
        return [means(inner, axes - 1) for inner in nested]
    return float(np.mean(nested))


@pytest.mark.parametrize("case", kit("sequential")["cases"], ids=named)
def test_the_conformance_kit_holds(case: dict[str, Any]) -> None:
    found = metrics.compute(
        means(case["sequential"], 3),
        means(case["single"], 2) if case.get("single") else None,
        episodes=cells([run[-1] for run in case["sequential"]], 2),
        floor=case["floor"],
        expert=case["expert"],
    )
    for name, expected in case["expected"].items():
        if expected is None:
            assert found[name].mean is None, name
            assert found[name].why, name
        else:
            assert found[name].runs == pytest.approx(expected, abs=1e-12), name


def test_three_lines_give_every_metric() -> None:
    values = metrics.compute(R, [0.5, 0.6, 1.0])
    assert list(values) == list(metrics.FORMULAS) == [metric.name for metric in TABLE]
    assert values["forgetting"].mean == pytest.approx(0.2)
    assert values["single_task_performance"].mean == pytest.approx(0.7)


def test_joint_runs_and_areas_give_the_metrics_that_need_them() -> None:
    values = metrics.compute(
        [R, R], joint=[[1.0, 1.0, 1.0]] * 3, auc=[[0.1, 0.4, 0.6]] * 2, single_auc=[[0.5, 0.2, 0.3]] * 2
    )
    assert values["joint_gap"].mean == pytest.approx(0.4)
    assert values["forward_transfer_auc"].mean == pytest.approx(((0.4 - 0.2) + (0.6 - 0.3)) / 2)


def test_practice_on_the_last_task_is_compared() -> None:
    values = metrics.compute(R, [0.5, 0.6, 1.0], cumulative=1.25)
    assert values["practice"].mean == pytest.approx(0.25)
    assert values["transfer_at_equal_practice"].mean == pytest.approx(0.9 - 1.25)
    assert values["last_task_performance"].mean == 1.25


def test_a_metric_without_a_value_says_what_it_needs() -> None:
    values = metrics.compute(R[1:])
    missing = {name: value.why for name, value in values.items() if value.mean is None}
    assert missing == {
        "asymptotic_transfer": "It needs single.",
        "zero_shot_transfer": "It needs a first row of the untrained agent.",
        "generalization_to_unseen_tasks": "It needs a first row of the untrained agent.",
        "forward_transfer_auc": "It needs auc and single_auc.",
        "joint_gap": "It needs joint.",
        "return_std": "It needs episodes.",
        "cvar_10": "It needs episodes.",
        "practice": "It needs single and cumulative.",
        "transfer_at_equal_practice": "It needs cumulative.",
        "last_task_performance": "It needs cumulative.",
        "single_task_performance": "It needs single.",
    }


@pytest.mark.parametrize(
    ("arguments", "where", "fact"),
    [
        ({"matrix": [[1.0, float("nan")], [0.0, 1.0]]}, "matrix", "index [0, 1] is nan"),
        ({"matrix": [1.0, 2.0]}, "matrix", "Its shape is (2,)"),
        ({"matrix": [[1.0, 2.0]]}, "matrix", "1 rows and 2 columns"),
        ({"matrix": [[1.0], [1.0, 2.0]]}, "matrix", "not an array of numbers"),
        ({"matrix": R, "single": [[1.0] * 3] * 2}, "single", "(2, 3)"),
        ({"matrix": R, "joint": [1.0] * 2}, "joint", "(1, 2)"),
        ({"matrix": R, "cumulative": [1.0] * 2}, "cumulative", "(2, 3)"),
        ({"matrix": R, "floor": [0.0] * 2}, "floor", "Give 3 numbers"),
        ({"matrix": R, "expert": [1.0, 0.0, 1.0]}, "expert", "task 2"),
    ],
)
def test_wrong_input_is_an_error_that_names_it(arguments: dict[str, Any], where: str, fact: str) -> None:
    with pytest.raises(BenchError) as caught:
        metrics.compute(**arguments)
    assert caught.value.where == where
    assert fact in str(caught.value)


@pytest.mark.parametrize(
    ("function", "arguments", "code"),
    [
        (metrics.iqm, ([[1.0, float("nan"), 2.0]],), "bad-matrix"),
        (metrics.profile, ([[float("nan")]],), "bad-matrix"),
        (metrics.probability_of_improvement, ([[1.0, 2.0]], [[1.0]]), "bad-matrix"),
        (metrics.probability_of_improvement, ([[1.0]], [[float("nan")]]), "bad-matrix"),
        (metrics.interval, ([],), "no-values"),
        (metrics.difference, ([1.0, 2.0], []), "no-values"),
        (metrics.interval, ([1.0, float("nan")],), "bad-values"),
        (metrics.interval, ([1.0, None],), "bad-values"),
        (metrics.interval, (3.0,), "bad-values"),
        (metrics.area, (range(10, 0, -1), [0.0] * 10, 10), "bad-curve"),
        (metrics.area, (range(10), [0.0] * 10, 10), "bad-curve"),
        (metrics.area, (range(1, 11), [0.0] * 9, 10), "bad-curve"),
        (metrics.area, (range(1, 11), [float("nan")] * 10, 10), "bad-curve"),
    ],
)
def test_values_that_have_no_statistic_are_an_error(function: Any, arguments: Any, code: str) -> None:
    with refused(code):
        function(*arguments)
