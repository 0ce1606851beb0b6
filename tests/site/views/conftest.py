"""The scorecards of the tests of boards."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from .made_boards import Card, Make, around, estimate


@pytest.fixture
def entry(document: Card) -> Make:
    """Makes a scorecard with one sequential log on hopper-gravity from the values of its runs."""
    pattern = document["submissions"][0]

    def make(name: str, final: list[float] | None, learning: list[float] | None = None, **facts: Any) -> Card:
        card: Card = copy.deepcopy(pattern)
        card.update(name=name, title=name.title(), trust=facts.pop("trust", "validated"))
        budget = facts.pop("budget", "100k")
        card["manifest"].update(facts)
        scores = card["groups"]["hopper-gravity-v0"]["sequential"]
        card["groups"] = {"hopper-gravity-v0": {"sequential": scores}}
        runs = final or [0.0] * 5
        scores.update(budget=budget, runs=list(range(len(runs))))
        scores["episode_sketches"] = [[repr(value)] for value in final or []]
        null: Card = {"mean": None, "low": None, "high": None, "runs": [], "why": "Every task is unsolved."}
        scores["metrics"] |= {
            "final_performance": estimate(final) if final else null,
            "learning_performance": estimate(learning or around(0.9, len(runs))),
            "forgetting": estimate(around(0.1, len(runs))),
        }
        return card

    return make
