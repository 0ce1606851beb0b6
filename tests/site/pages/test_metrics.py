"""The page of metrics, and its worked example."""

from __future__ import annotations

import re

import pytest

from gym_extensions.scoring.formulas import METRICS
from gym_extensions.site.pages.metrics import example

from ..browser import read


def test_the_metrics_page_has_every_formula_of_the_scorer() -> None:
    page = read({"format": 1, "references": {"version": "x", "sha256": ""}, "submissions": []})
    text = page["metrics.html"].text
    for metric in (metric for protocol in METRICS.values() for metric in protocol):
        assert re.sub(r"\s+", " ", metric.formula) in text
        assert metric.name in page["metrics.html"].ids


def test_values_by_hand() -> None:
    values = example()["results"]
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
        "last_task_performance": 0.95,
    }
    assert {name: values[name] for name in by_hand} == pytest.approx(by_hand)
