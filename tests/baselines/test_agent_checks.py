"""A factory, agent or card that does not fit is rejected with a clear message before training."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, train
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.algorithms.zero import Zero
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.manifest import EVALUATIONS
from gym_extensions.rollouts.rules.manifest import bad_hyperparameter, bad_value


class AgentWithCard(Zero):
    """An agent that returns the card of the test."""

    def __init__(self, card: Any) -> None:
        self._card = card

    def card(self) -> Any:
        return self._card


def changed(settings: Any = None, **values: Any) -> Card:
    return replace(Card("mine"), hyperparameters={} if settings is None else settings, **values)


HINT = "Use a string, a finite number, true or false, or a list of them."
COUNT = "is not an integer from 0 to 2⁵³ − 1. Give an integer from 0."
GIVE_TEXT = "Give a string of at most 100 characters."
BAD_CARDS = [
    ({"algorithm": "mine"}, ": Expected a Card, got dict. Return a gym_extensions.baselines.Card."),
    (
        changed(evaluation="greedy"),
        ".evaluation: The value is 'greedy'. Choose one of: deterministic, sampled.",
    ),
    (changed(evaluation="sample"), ".evaluation: The value is 'sample'. Did you mean 'sampled'?"),
    (changed(title="x" * 101), f".title: The string has 101 characters; the limit is 100. {GIVE_TEXT}"),
    (changed(title=3), f".title: 3 is not a string. {GIVE_TEXT}"),
    (changed(algorithm=" "), ": The algorithm has no name. Give a name, such as 'SAC'."),
    (changed(parameters=np.int64(3)), f".parameters: np.int64(3) {COUNT}"),
    (changed(stored_steps=-1), f".stored_steps: -1 {COUNT}"),
    (
        changed(packages=("torhc",)),
        ".packages: The package 'torhc' is not installed. Use the names that pip lists.",
    ),
    (
        changed(packages=("numpy",)),
        ".packages: The manifest always states the version of 'numpy'. Leave it out.",
    ),
    (changed([3]), ": hyperparameters is of type list. Use a dict of values by name."),
    (changed({3: 1}), ": The hyperparameter name 3 is not a string. Use strings as names."),
    (changed({"rate": float("nan")}), f": Hyperparameter 'rate' is not finite. {HINT}"),
    (changed({"clip": float("inf")}), f": Hyperparameter 'clip' is not finite. {HINT}"),
    (changed({"clip": np.float32(1)}), f": Hyperparameter 'clip' is of type float32. {HINT}"),
    (changed({"net": {"pi": 3}}), f": Hyperparameter 'net' is of type dict. {HINT}"),
    (changed({"net": [[3]]}), f": Hyperparameter 'net' contains an element of type list. {HINT}"),
    (changed({"mask": 2**63}), f": Hyperparameter 'mask' is too large. {HINT}"),
    (changed({"sizes": [1] * 101}), f": Hyperparameter 'sizes' has 101 elements; the limit is 100. {HINT}"),
    (
        changed({"text": "x" * 4001}),
        f": Hyperparameter 'text' has 4001 characters; the limit is 4000. {HINT}",
    ),
]


@pytest.mark.parametrize(("card", "message"), BAD_CARDS, ids=[message[:40] for _, message in BAD_CARDS])
def test_a_card_that_the_manifest_cannot_store_is_rejected(card: Any, message: str) -> None:
    with pytest.raises(BenchError) as error:
        card_of(AgentWithCard(card), "mine")
    assert str(error.value) == f"card(){message}"


@pytest.mark.parametrize("name", ["task_in_training", "task_in_evaluation", "boundaries"])
def test_a_card_does_not_declare_what_the_agent_observes(name: str) -> None:
    values: dict[str, Any] = {name: True}
    with pytest.raises(BenchError) as error:
        Card("mine", **values)
    assert str(error.value) == (
        f"Card(): A card does not have the field {name!r}. "
        f"If the agent observes it, give its class the attribute observes = Observes({name}=True)."
    )


def test_a_card_pickles() -> None:
    card = changed({"rate": 0.1}, title="Mine")
    assert pickle.loads(pickle.dumps(card)) == card  # noqa: S301


class Greedy(Zero):
    def card(self) -> Card:
        return replace(super().card(), evaluation="greedy")


def test_a_bad_card_is_rejected_before_anything_runs(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match=r"card\(\)\.evaluation: The value is 'greedy'\."):
        train(Greedy, "hopper-gravity", "single", "smoke", 0, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


GOOD_SETTINGS = [1, -2.5, True, "text", [1, 2.5], ("a", False), [], "x" * 4000, [1] * 100, 2**63 - 1]


@pytest.mark.parametrize("value", GOOD_SETTINGS, ids=[repr(value)[:20] for value in GOOD_SETTINGS])
def test_a_setting_accepted_here_passes_the_rule_of_the_manifest(value: Any) -> None:
    card = card_of(AgentWithCard(changed({"setting": value})), "mine")
    stored = list(value) if isinstance(value, tuple) else value
    assert card.hyperparameters == {"setting": value}
    assert not list(bad_hyperparameter({"hyperparameters": {"setting": stored}}))


@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_each_evaluation_mode_passes_the_rule_of_the_manifest(evaluation: str) -> None:
    tables: Mapping[str, Any] = {"protocol": {"evaluation": evaluation}}
    assert not list(bad_value(dict(tables)))


class NoMethods:
    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        pass


class OnlyLearn(NoMethods):
    def learn(self, env: Any, steps: int) -> None:
        pass


class OnlyAct(NoMethods):
    def act(self, observations: Any) -> Any:
        return np.zeros((len(observations), 3))


def without_arguments() -> OnlyAct:
    return OnlyAct(None, None, 0)


EXAMPLE = "docs/submit.md has an example."
FACTORY = (
    "Pass an agent's name, or a class or function with the arguments (observation_space, action_space, seed)."
)
BAD_FACTORIES = [
    (
        OnlyAct,
        "OnlyAct: The agent, of type OnlyAct, has no method learn(). "
        f"Add a method learn(env, steps); {EXAMPLE}",
    ),
    (
        OnlyLearn,
        "OnlyLearn: The agent, of type OnlyLearn, has no method act(). "
        f"Add a method act(observations); {EXAMPLE}",
    ),
    (
        without_arguments,
        "without_arguments: The factory cannot be called with (observation_space, action_space, seed): "
        "too many positional arguments. Give it these three arguments.",
    ),
    (Zero.__new__(Zero), f"Zero: Expected a factory of agents, got a value of type Zero. {FACTORY}"),
    (17, f"int: Expected a factory of agents, got a value of type int. {FACTORY}"),
]


def training_error(agent: Any, out: Path) -> str:
    with pytest.raises(BenchError) as error:
        train(agent, "hopper-gravity", "sequential", "smoke", 0, out=out)
    return str(error.value)


@pytest.mark.parametrize(
    ("agent", "message"), BAD_FACTORIES, ids=[row[1].partition(":")[0] for row in BAD_FACTORIES]
)
def test_a_factory_that_does_not_fit_is_rejected_before_anything_runs(
    agent: Any, message: str, tmp_path: Path
) -> None:
    assert training_error(agent, tmp_path / "out") == message
    assert not (tmp_path / "out").exists()


def test_an_error_inside_the_factory_is_raised_unchanged(tmp_path: Path) -> None:
    def broken(observation_space: Any, action_space: Any, seed: int) -> Zero:
        raise TypeError("mine")

    with pytest.raises(TypeError, match=r"^mine$"):
        train(broken, "hopper-gravity", "sequential", "smoke", 0, out=tmp_path)
