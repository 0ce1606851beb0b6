"""Cards that no manifest takes are refused before training, word for word."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gym_extensions.baselines.agent import Card
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.algorithms.still import Still
from gym_extensions.baselines.train import train
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.manifest import EVALUATIONS
from gym_extensions.rollouts.rules.manifest import bad_hyperparameter, bad_value


class Carded:
    def __init__(self, card):
        self.given = card

    def card(self):
        return self.given


def changed(settings=None, **values):
    return replace(Card("mine"), hyperparameters={} if settings is None else settings, **values)


PLAIN = "Give a string, a finite number, true or false, or a list of them."
COUNT = "is not an integer from 0 to 2⁵³ − 1. Give an integer from 0."
BAD = [
    (
        {"algorithm": "mine"},
        ": The agent's card is of kind dict. Return a gym_extensions.baselines.agent.Card.",
    ),
    (
        changed(evaluation="greedy"),
        ".evaluation: The value is 'greedy'. Choose one of: deterministic, sampled.",
    ),
    (changed(evaluation="sample"), ".evaluation: The value is 'sample'. Did you mean 'sampled'?"),
    (changed(title="x" * 101), ".title: The string has 101 characters; the limit is 100. Give a string."),
    (changed(boundaries=1), ".boundaries: 1 is not true or false. Give true or false."),
    (changed(parameters=np.int64(3)), f".parameters: np.int64(3) {COUNT}"),
    (changed(stored_steps=-1), f".stored_steps: -1 {COUNT}"),
    (changed(settings=[3]), ": hyperparameters is of kind list. Give a dict of settings by name."),
    (
        changed(settings={3: 1}),
        ": The hyperparameter 3 has no text for a name. Name each setting by a text.",
    ),
    (changed(settings={"rate": float("nan")}), f": The hyperparameter 'rate' is not finite. {PLAIN}"),
    (changed(settings={"clip": float("inf")}), f": The hyperparameter 'clip' is not finite. {PLAIN}"),
    (changed(settings={"clip": np.float32(1)}), f": The hyperparameter 'clip' is of type float32. {PLAIN}"),
    (changed(settings={"net": {"pi": 3}}), f": The hyperparameter 'net' is of type dict. {PLAIN}"),
    (
        changed(settings={"net": [[3]]}),
        f": The hyperparameter 'net' contains an element of type list. {PLAIN}",
    ),
    (changed(settings={"mask": 2**63}), f": The hyperparameter 'mask' is too large. {PLAIN}"),
    (
        changed(settings={"sizes": [1] * 101}),
        f": The hyperparameter 'sizes' has 101 elements; the limit is 100. {PLAIN}",
    ),
    (
        changed(settings={"about": "x" * 4001}),
        f": The hyperparameter 'about' has 4001 characters; the limit is 4000. {PLAIN}",
    ),
]


@pytest.mark.parametrize(("card", "message"), BAD, ids=[message[:40] for _, message in BAD])
def test_a_card_that_no_manifest_takes_is_refused(card, message):
    with pytest.raises(BenchError) as told:
        card_of(Carded(card), "mine")
    assert str(told.value) == f"card(){message}"


class Greedy(Still):
    def card(self):
        return replace(super().card(), evaluation="greedy")


def test_it_is_refused_before_anything_is_run(tmp_path):
    with pytest.raises(BenchError, match=r"card\(\)\.evaluation: The value is 'greedy'\."):
        train(Greedy, "hopper-gravity", "single", "smoke", 0, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


GOOD = [1, -2.5, True, "text", [1, 2.5], ("a", False), [], "x" * 4000, [1] * 100, 2**63 - 1]


@pytest.mark.parametrize("value", GOOD, ids=[repr(value)[:20] for value in GOOD])
def test_what_is_let_through_here_passes_the_check_of_a_submission(value):
    card = card_of(Carded(changed(settings={"it": value})), "mine")
    written = list(value) if isinstance(value, tuple) else value
    assert card.hyperparameters == {"it": value}
    assert not list(bad_hyperparameter({"hyperparameters": {"it": written}}))


@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_each_way_of_acting_passes_the_check_of_a_submission(evaluation):
    assert not list(bad_value({"protocol": {"evaluation": evaluation}}))
