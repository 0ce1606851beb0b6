"""Labels of tasks, groups, budgets, trust and missing files."""

from __future__ import annotations

import msgspec
import pytest
from markupsafe import Markup

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.text import labels

from ..conftest import submission


@pytest.mark.parametrize(
    ("task_id", "label"),
    [
        ("gym_extensions/HopperWall-v0", "Hopper<wbr>Wall"),
        ("gym_extensions/HopperWall-v1", "Hopper<wbr>Wall-v1"),
        ("gym_extensions/HopperWall-v12", "Hopper<wbr>Wall-v12"),
        ("HopperWall", "Hopper<wbr>Wall"),
        ("<b>-v0", "&lt;b&gt;"),
    ],
)
def test_a_task_has_no_namespace_and_a_version_from_1_on(task_id: str, label: str) -> None:
    assert labels.task(task_id) == Markup(label)


@pytest.mark.parametrize("version", [0, 1, 10])
def test_a_variation_omits_the_base_name_in_every_version(version: int) -> None:
    base, half = (f"gym_extensions/{name}-v{version}" for name in ("Hopper", "HopperGravityHalf"))
    suffix = f"-v{version}" if version else ""
    assert labels.variation(base, (half, base)) == f"Hopper{suffix}"
    assert labels.variation(half, (half, base)) == f"Gravity<wbr>Half{suffix}"


def test_a_variation_of_a_group_without_a_common_base_keeps_its_name() -> None:
    assert labels.variation("HopperWall-v0", ("HopperWall-v0", "Walker2dWall-v0")) == "Hopper<wbr>Wall"


@pytest.mark.parametrize(
    ("group_id", "label"),
    [
        ("hopper-gravity-v0", 'hopper-gravity<span class="version">-v0</span>'),
        ("hopper-gravity-v11", 'hopper-gravity<span class="version">-v11</span>'),
        ("maze-vision", "maze-vision"),
        ("gravity", 'gravity <span class="version">suite, mean of 4 groups</span>'),
    ],
)
def test_a_group_shows_its_version_and_a_suite_its_size(group_id: str, label: str) -> None:
    assert labels.group(group_id) == Markup(label)


def test_a_budget_has_steps_per_task_and_a_purpose() -> None:
    assert [labels.budget(name) for name in ("paper", "1M", "100k")] == [
        "paper",
        "1M (standard)",
        "100k (quick)",
    ]
    steps = "100\u202f000 training steps per task"
    assert labels.budget_steps("100k", "hopper-gravity-v0") == steps
    assert labels.budget_steps("paper", "hopper-body-v1") == "25\u202f000\u202f000 training steps per task"


def test_a_missing_file_is_named_after_its_protocol() -> None:
    assert labels.missing(["joint.csv", "5 runs"]) == "the protocol “all tasks at once” (joint.csv), 5 runs"


@pytest.mark.parametrize(
    ("trust", "level", "label"),
    [
        ("validated", "validated", "checked, not replayed"),
        ("replayed (sample: 75 of 3500 episodes)", "replayed", "replayed (sample: 75 of 3500 episodes)"),
        ("reported", "reported", "reported"),
        (None, "refused", "refused"),
        ("blessed", "other", "blessed"),
    ],
)
def test_a_level_of_trust_has_a_style_and_a_label(trust: str | None, level: str, label: str) -> None:
    card = msgspec.convert({**submission("a", {}), "trust": trust}, Scorecard)
    assert (labels.level(card), labels.trust(card)) == (level, label)


def test_an_agent_without_task_information_says_none() -> None:
    observes = {"task_in_training": True, "task_in_evaluation": False, "boundaries": True}
    card = msgspec.convert(submission("a", {}, observes=observes), Scorecard)
    assert labels.observed(card) == "task label in training, task boundaries"
    blind = msgspec.convert(submission("a", {}, observes=dict.fromkeys(observes, False)), Scorecard)
    assert labels.observed(blind) == "none"
