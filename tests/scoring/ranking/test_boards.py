"""Which boards exist, in which order, and which scores of a submission a board shows."""

from dataclasses import replace
from typing import Any

from gym_extensions.catalog.groups import SUITES
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.group_score import GroupScore, SuiteScore
from gym_extensions.scoring.ranking.boards import BoardKey, board_keys, lookup
from gym_extensions.scoring.scorecard import Scorecard

METRICS = {"final_performance": MetricValue(mean=0.5, runs=(0.5,))}


def on_group(budget: str) -> GroupScore:
    facts: dict[str, Any] = {"tasks": (), "reference": {}, "return_matrix": (((1.0,),),), "metrics": METRICS}
    return GroupScore(level="verified", budget=budget, runs=(0,), **facts)


def card(groups: dict[str, dict[str, str]], suites: dict[str, str] | None = None) -> Scorecard:
    """A scorecard with budgets by group and protocol, and sequential budgets by suite."""
    scores = {name: {key: on_group(budget) for key, budget in each.items()} for name, each in groups.items()}
    means = {
        name: {"sequential": SuiteScore(budget, SUITES[name], METRICS)}
        for name, budget in (suites or {}).items()
    }
    return Scorecard(name="a", title="A", level="verified", manifest=None, groups=scores, suites=means)


def test_groups_are_before_suites_then_by_name_protocol_and_budget() -> None:
    cards = [
        card({"walker2d-gravity-v0": {"joint": "1M", "single": "1M", "sequential": "100k"}}),
        card({"hopper-gravity-v0": {"sequential": "paper"}}, suites={"gravity": "1M"}),
        card({"walker2d-gravity-v0": {"sequential": "1M"}}),
    ]
    cards.append(card({"hopper-gravity-v0": {"sequential": "smoke"}}))  # on no board
    assert board_keys(cards) == [
        BoardKey("hopper-gravity-v0", "sequential", "paper", False),
        BoardKey("walker2d-gravity-v0", "sequential", "1M", False),
        BoardKey("walker2d-gravity-v0", "sequential", "100k", False),
        BoardKey("walker2d-gravity-v0", "single", "1M", False),
        BoardKey("walker2d-gravity-v0", "joint", "1M", False),
        BoardKey("gravity", "sequential", "1M", False),
    ]


def test_a_board_shows_the_score_of_its_group_protocol_and_budget() -> None:
    submission = card({"hopper-gravity-v0": {"sequential": "1M"}}, suites={"gravity": "1M"})
    key = BoardKey("hopper-gravity-v0", "sequential", "1M", False)
    assert lookup(submission, key) is submission.groups["hopper-gravity-v0"]["sequential"]
    assert lookup(submission, replace(key, group="gravity")) is submission.suites["gravity"]["sequential"]
    assert lookup(submission, replace(key, group="humanoid-gravity-v0")) is None
    assert lookup(submission, replace(key, protocol="joint")) is None
    assert lookup(submission, replace(key, budget="100k")) is None
    assert lookup(submission, replace(key, task_conditioned=True)) is None
