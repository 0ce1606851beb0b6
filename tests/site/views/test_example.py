"""The worked example of the page of metrics agrees with the sentences around it."""

from __future__ import annotations

import pytest

from gym_extensions.scoring.metrics.definitions import BY_NAME
from gym_extensions.site.views.example import example_values


def test_every_metric_has_a_value_and_says_what_it_does_not_show() -> None:
    assert set(example_values()) == set(BY_NAME)
    assert None not in example_values().values()
    assert all(metric.limits.endswith(".") for metric in BY_NAME.values())


def test_values_by_hand() -> None:
    values = example_values()
    by_hand = {
        "final_performance": 0.7,
        "learning_performance": 0.9,
        "forgetting": 0.3,
        "worst_case_forgetting": 0.3,
        "mean_later_forgetting": ((0.3 + 0.4) / 2 + 0.2) / 2,
        "asymptotic_transfer": 0.1,
        "zero_shot_transfer": (0.1 + 0.3) / 2,
        "generalization_to_unseen_tasks": (0.1 + 0.1 + 0.3) / 3,
        "forward_transfer_auc": 0.2,
        "joint_gap": 0.2,
        "cvar_10": 0.7 - 0.18,
        "single_task_performance": 2.5 / 3,
    }
    assert {name: values[name] for name in by_hand} == pytest.approx(by_hand)
