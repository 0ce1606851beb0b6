"""Labels of budgets, levels of trust, missing files and task information."""

from __future__ import annotations

import msgspec
import pytest

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.text import labels

from ..conftest import submission


def test_a_budget_has_steps_per_task_and_a_purpose() -> None:
    assert [labels.budget(name) for name in ("paper", "1M", "300k", "100k")] == [
        "paper",
        "1M (long)",
        "300k (standard)",
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


@pytest.mark.parametrize(
    ("trust", "parts"),
    [
        ("replayed (salted sample: 220 of 3000 episodes)", ("replayed", "220 of 3000 episodes")),
        ("replayed (all)", ("replayed", "all episodes")),
        ("validated", ("checked, not replayed", "")),
    ],
)
def test_a_board_shows_the_level_of_trust_and_the_episodes_apart(trust: str, parts: tuple[str, str]) -> None:
    card = msgspec.convert({**submission("a", {}), "trust": trust}, Scorecard)
    assert labels.trust_sample(card) == parts
