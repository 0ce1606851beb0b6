"""The attribute ``observes`` and the arguments of ``act`` are checked before training."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, Context, Observes, train
from gym_extensions.baselines.algorithms.zero import Zero
from gym_extensions.baselines.context_checks import action_function, check_context, observes_of
from gym_extensions.baselines.submission import manifest
from gym_extensions.errors import BenchError

OBSERVATIONS = np.zeros((2, 3))
CONTEXT = Context(np.ones(2, bool))


class WithAct:
    """An agent with the ``act`` and the ``observes`` of the test."""

    def __init__(self, act: Callable[..., Any], observes: Any = None) -> None:
        self.act = act
        if observes is not None:
            self.observes = observes

    def learn(self, env: Any, steps: int) -> None:
        """Does nothing."""


def optional(observations: Any, context: Any = None) -> Any:
    return context


def keyword(observations: Any, *, context: Any) -> Any:
    return context


def another_name(observations: Any, seen: Any) -> Any:
    return seen


def two_arguments(observations: Any, context: Any, deterministic: bool = True) -> Any:
    return context


def option(observations: Any, deterministic: bool = True) -> Any:
    return None if deterministic is True else deterministic


def options(observations: Any, *rest: Any, **more: Any) -> Any:
    return (rest or more) or None


def alone(observations: Any) -> Any:
    return None


@pytest.mark.parametrize("act", [optional, keyword, another_name, two_arguments])
def test_an_agent_with_a_second_parameter_receives_the_context(act: Callable[..., Any]) -> None:
    agent = WithAct(act)
    check_context(agent, "mine")
    received: object = action_function(agent)(OBSERVATIONS, CONTEXT)
    assert received is CONTEXT


@pytest.mark.parametrize("act", [alone, option, options])
def test_another_agent_receives_observations_alone(act: Callable[..., Any]) -> None:
    agent = WithAct(act)
    check_context(agent, "mine")
    received: object = action_function(agent)(OBSERVATIONS, CONTEXT)
    assert received is None


def third(observations: Any, context: Any, mode: str) -> Any: ...


def required_option(observations: Any, *, mode: str) -> Any: ...


ALLOWED = "Use act(observations) or act(observations, context)."
BAD_AGENTS = [
    (
        WithAct(alone, True),
        "The agent's attribute observes is of type bool. Use a gym_extensions.baselines.Observes.",
    ),
    (
        WithAct(alone, {"boundaries": True}),
        "The agent's attribute observes is of type dict. Use a gym_extensions.baselines.Observes.",
    ),
    (
        WithAct(alone, Observes(boundaries=1)),  # type: ignore[arg-type]
        "The agent's observes.boundaries is 1. Use True or False.",
    ),
    (WithAct(third), f"act() requires the argument 'mode'. {ALLOWED}"),
    (WithAct(required_option), f"act() requires the argument 'mode'. {ALLOWED}"),
    (
        WithAct(alone, Observes(task_in_evaluation=True)),
        "The agent asks for task_in_evaluation, but act() does not receive the context. "
        "Use act(observations, context).",
    ),
]


@pytest.mark.parametrize(("agent", "message"), BAD_AGENTS, ids=[row[1][:45] for row in BAD_AGENTS])
def test_an_agent_that_cannot_receive_what_it_asks_for_is_rejected(agent: Any, message: str) -> None:
    with pytest.raises(BenchError) as error:
        check_context(agent, "mine")
    assert (error.value.code, str(error.value)) == ("bad-agent", f"mine: {message}")


def test_an_agent_without_the_attribute_observes_nothing_more() -> None:
    assert observes_of(WithAct(alone), "mine") == Observes()


class Undecided(Zero):
    """An agent that asks for the boundaries only if its seed is not 0."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        super().__init__(observation_space, action_space, seed)
        self.observes = Observes(boundaries=seed > 0)


def test_agents_of_one_factory_ask_for_the_same(tmp_path: Path) -> None:
    with pytest.raises(BenchError) as error:
        train(Undecided, "pusher", "sequential", "smoke", 0, out=tmp_path / "out")
    assert str(error.value) == (
        "Undecided: The agent of pusher sequential-run0 asks for Observes(task_in_training=False, "
        "task_in_evaluation=False, boundaries=True), another agent for Observes(task_in_training=False, "
        "task_in_evaluation=False, boundaries=False). "
        "Give all agents of a factory the same attribute observes."
    )


def test_a_submission_that_declares_otherwise_is_rejected_before_anything_runs(tmp_path: Path) -> None:
    new = manifest.run_sections(Card("zero", evaluation="deterministic"), "smoke", None, Observes(True))
    path = tmp_path / "submission.toml"
    manifest.write(path, new)
    with pytest.raises(
        BenchError, match=r"observes\.task_in_training is True in this submission and False in"
    ):
        train("zero", "pusher", "sequential", "smoke", 0, out=tmp_path)
    assert list(tmp_path.iterdir()) == [path]
