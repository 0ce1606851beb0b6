"""A factory, agent or card that does not fit is rejected before training; who receives the context."""

import warnings
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import numpy as np
import pandas as pd
import pytest
from gymnasium.vector import AutoresetMode

from gym_extensions.baselines import Card, Context, Observes, agent_spec, train
from gym_extensions.baselines.agent import TaskLabel, action_function, autoreset_mode_of, check_context
from gym_extensions.baselines.agent_spec import NO_FOLDER, AgentSpec, checked_card
from gym_extensions.baselines.algorithms.floors import Zero
from gym_extensions.baselines.submission import manifest_tables
from gym_extensions.baselines.training.jobs import Settings
from gym_extensions.catalog.protocol import budget
from gym_extensions.errors import BenchError
from gym_extensions.submissions.rules import problems

from ..conftest import refused
from .conftest import QUICK_GROUP


class AgentWithCard(Zero):
    """An agent that returns the card of the test."""

    def __init__(self, card: Any) -> None:
        self._card = card

    def card(self) -> Any:
        return self._card


def changed(settings: Any = None, **values: Any) -> Card:
    return replace(Card("mine"), hyperparameters={} if settings is None else settings, **values)


BAD_CARDS: list[tuple[Any, str]] = [
    ({"algorithm": "mine"}, "dict"),
    (changed(evaluation="greedy"), "'greedy'"),
    (changed(title="x" * 101), "title"),
    (changed(title=3), "title"),
    (changed(description="two\r\nlines"), "description"),
    (changed(algorithm=" "), "no name"),
    (changed(algorithm=3), "algorithm"),
    (changed(parameters=3.0), "parameters"),
    (changed(stored_steps=-1), "stored_steps"),
    (changed(tuning_tasks="Hopper"), "tuning_tasks"),
    (changed(packages=("torhc",)), "'torhc' is not installed"),
    (changed(packages=("numpy",)), "'numpy'"),
    (changed([3]), "hyperparameters"),
    (changed({3: 1}), "key"),
    (changed({"rate": float("nan")}), "rate"),
    (changed({"net": {"pi": 3}}), "dict"),
    (changed({"sizes": [1] * 101}), "101"),
]


@pytest.mark.parametrize(("card", "named"), BAD_CARDS)
def test_a_card_that_scoring_would_refuse_is_rejected(card: Any, named: str) -> None:
    with refused("bad-card", named):
        checked_card(AgentWithCard(card), "mine")


def test_integers_of_numpy_are_counts() -> None:
    card = checked_card(AgentWithCard(changed(parameters=np.prod((3, 5)), stored_steps=np.int32(7))), "mine")
    assert (repr(card.parameters), repr(card.stored_steps)) == ("15", "7")


SETTINGS = [-2.5, True, [1, 2.5], ("a", False), [], "x" * 4000, 2**63 - 1, np.float64(1), [np.int64(3)]]


@pytest.mark.parametrize("value", SETTINGS)
def test_a_setting_accepted_here_has_no_finding_in_the_manifest(value: Any) -> None:
    card = checked_card(AgentWithCard(changed({"setting": value})), "mine")
    spec = AgentSpec("mine", AgentWithCard, card, Observes())  # type: ignore[arg-type]
    tables = manifest_tables(Settings(spec, budget("smoke")))
    assert [each.rule for each in problems("manifest", NO_FOLDER, tables)] == ["no-groups"]


def with_methods(**methods: Any) -> Any:
    """A class of agents with these methods."""
    return type("Mine", (), {"__init__": lambda self, *spaces_and_seed: None, **methods})


@pytest.mark.parametrize(
    ("agent", "named"),
    [
        (with_methods(act=lambda self, observations: None), "learn()"),
        (type("Mine", (Zero,), {"card": Card("mine")}), "def card(self)"),
        (with_methods(learn=lambda self, env, steps: None), "act()"),
        (lambda: None, "(observation_space, action_space, seed)"),
        (Zero.__new__(Zero), "type Zero"),
        (17, "type int"),
    ],
)
def test_a_factory_that_does_not_fit_is_rejected_at_once(agent: Any, named: str, tmp_path: Path) -> None:
    with refused("bad-agent", named):
        train(agent, "hopper-gravity", "sequential", "smoke", 0, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


CONTEXT = Context(np.ones(2, bool))


def with_act(act: Callable[..., Any], observes: Any = None) -> Any:
    """An agent with this ``act``, and with ``observes`` if it is given."""
    stated = {} if observes is None else {"observes": observes}
    return SimpleNamespace(act=act, learn=lambda env, steps: None, **stated)


@pytest.mark.parametrize(
    ("act", "receives"),
    [
        (lambda observations, context=None: context, True),
        (lambda observations, *, context: context, True),
        (lambda observations, context, deterministic=True: context, True),
        (lambda observations: None, False),
        (lambda observations, deterministic=True: None if deterministic is True else deterministic, False),
        (lambda observations, *rest, **more: (rest or more) or None, False),
    ],
)
def test_an_agent_with_a_parameter_context_receives_it(act: Callable[..., Any], receives: bool) -> None:
    agent = with_act(act)
    check_context(agent, "mine")
    received: object = action_function(agent)(np.zeros((2, 3)), CONTEXT)
    assert received is (CONTEXT if receives else None)


def alone(observations: Any) -> None: ...


@pytest.mark.parametrize(
    ("agent", "named"),
    [
        (with_act(alone, True), "observes is True"),
        (with_act(alone, Observes(boundaries=1)), "boundaries=1"),  # type: ignore[arg-type]
        (with_act(lambda observations, seen: None), "'seen'"),
        (with_act(lambda observations, context, mode: None), "'mode'"),
        (with_act(lambda observations, *, mode: None), "'mode'"),
        (with_act(alone, Observes(task_in_evaluation=True)), "task_in_evaluation"),
    ],
)
def test_an_agent_that_cannot_receive_what_it_asks_for_is_rejected(agent: Any, named: str) -> None:
    with refused("bad-agent", named):
        check_context(agent, "mine")


class Undecided(Zero):
    """An agent that asks for the boundaries only if its seed is not 0."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        super().__init__(observation_space, action_space, seed)
        self.observes = Observes(boundaries=seed > 0)


def test_agents_of_one_factory_ask_for_the_same(tmp_path: Path) -> None:
    with refused("bad-agent", "boundaries=True), another agent Observes"):
        train(Undecided, "pusher", "sequential", "smoke", 0, out=tmp_path / "out")


def test_the_task_is_in_the_context_of_an_agent_that_asked_for_it_alone() -> None:
    context = Context(CONTEXT.episode_starts, TaskLabel("gym_extensions/Hopper-v0", 2))
    assert (context.task_id, context.task) == ("gym_extensions/Hopper-v0", 2)
    assert "Hopper" not in repr(context)
    for name in ("task_id", "task"):
        with refused("not-requested"):
            getattr(CONTEXT, name)
        assert not hasattr(CONTEXT, name)


class Restored(Zero):
    """An agent with a folder as checkpoint."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        super().__init__(observation_space, action_space, seed)
        self.action = seed / 10

    def act(self, observations: Any) -> Any:
        return super().act(observations) + self.action

    def save(self, path: Path) -> None:
        path.mkdir()
        np.save(path / "action.npy", self.action)

    def load(self, path: Path) -> Any:
        self.action = float(np.load(path / "action.npy"))


def checked(agent: Any, protocol: str = "sequential") -> AgentSpec:
    return AgentSpec.of(agent, [(QUICK_GROUP, protocol)])


def restored(load: Callable[[Any, Path], Any]) -> Any:
    """Such agents with another ``load``."""
    return type("Mine", (Restored,), {"load": load})


def test_what_load_returns_is_an_agent_or_nothing() -> None:
    checked(Restored)
    returns_true = restored(lambda self, path: True)
    for protocol in ("sequential", "joint"):  # also of one stage: evaluations during training load a copy
        with refused("bad-agent", "load() returned a value of type bool"):
            checked(returns_true, protocol)

    def raises(self: Any, path: Path) -> None:
        raise ValueError("The file is too old.")

    with refused("bad-checkpoint", "ValueError: The file is too old. Correct load()"):
        checked(restored(raises))


def test_a_load_that_does_not_restore_the_agent_is_a_warning_before_training() -> None:
    with pytest.warns(UserWarning, match=r"After save\(\) and load\(\) the agent takes other actions"):
        checked(restored(lambda self, path: None))


class Undeclared(Zero):
    """An agent with a data frame and memory, without a card."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        super().__init__(observation_space, action_space, seed)
        self.settings = {"table": pd.DataFrame()}


def test_an_agent_that_holds_objects_of_packages_and_names_none_is_warned() -> None:
    with pytest.warns(UserWarning, match="holds objects of pandas, and its card names no packages"):
        checked(Undeclared)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        card = Card("declared", packages=("pandas",), stored_steps=1000)
        checked(type("Declared", (Undeclared,), {"card": lambda self: card}))


def warned(do: Callable[[], object]) -> str:
    """The texts of its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        do()
    return "\n".join(str(each.message) for each in caught)


@pytest.mark.parametrize(
    ("policy", "steps", "is_warned"),
    [(None, "100k", True), (None, "smoke", False), (Zero.policy, "100k", False)],
)
def test_an_agent_without_policy_is_warned_where_there_are_ranks(
    policy: Any, steps: str, is_warned: bool, tmp_path: Path
) -> None:
    def learn(self: Any, env: Any, steps: int) -> None:
        raise ZeroDivisionError

    def begin() -> None:
        with pytest.raises(ZeroDivisionError):
            train(agent, QUICK_GROUP, "joint", steps, 0, out=tmp_path / "mine", progress=False)

    agent: Any = type("Mine", (Zero,), {"policy": policy, "learn": learn})
    assert ("Add a method policy()" in warned(begin)) == is_warned


@pytest.mark.parametrize(
    ("card", "taken", "is_warned"),
    [
        (Card("mine"), 0, True),
        (Card("mine"), 499, True),
        (Card("mine"), 500, False),
        (Card("zero"), 0, False),
        (Card("random"), 0, False),
    ],
)
def test_an_agent_that_takes_less_than_half_of_its_steps_is_warned(
    card: Card, taken: int, is_warned: bool
) -> None:
    text = warned(lambda: agent_spec.warn_of_few_steps(card, taken, 1000))
    assert (f"took {taken} of 1,000 steps" in text) == is_warned


def test_the_steps_that_an_agent_takes_are_those_of_a_stage_with_training(tmp_path: Path) -> None:
    idle: Any = type("Idle", (Zero,), {"card": lambda self: Card("mine")})
    text = warned(lambda: train(idle, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path / "mine"))
    assert text.count("learn() took 0 of 1,000 steps") == 2


@pytest.mark.parametrize(
    ("held", "is_memory"),
    [
        ({"buffer": {"seen": np.zeros((500, 2, 23))}}, True),
        ({"buffer": deque([(np.zeros(23), 0.0)] * 1000)}, True),
        ({"weights": np.zeros((23, 2000)), "losses": [0.5] * 5000, "last": np.zeros((25, 23))}, False),
        ({"space": gym.spaces.Dict(), "norm": [np.float64(0.5)] * 5000}, False),  # its shape is None
    ],
)
def test_an_agent_that_holds_steps_and_states_none_is_warned(held: dict[str, Any], is_memory: bool) -> None:
    agent = Zero.__new__(Zero)
    vars(agent).update(held)
    with warnings.catch_warnings(record=True) as caught:
        agent_spec.warn_of_stored_steps(agent, (23,))
    shown = ["about 1,000 steps, and its card says stored_steps=0" in str(each.message) for each in caught]
    assert shown == [True] * is_memory


def test_the_autoreset_mode_is_one_of_gymnasium() -> None:
    agent = Zero.__new__(Zero)
    assert autoreset_mode_of(agent, "mine") is AutoresetMode.NEXT_STEP
    vars(agent)["autoreset_mode"] = "same"
    with pytest.raises(BenchError, match="autoreset_mode is 'same'"):
        autoreset_mode_of(agent, "mine")
