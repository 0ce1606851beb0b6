"""Agents that the loop cannot run are told in a sentence, before anything is trained where that can be."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines.algorithms.still import Still
from gym_extensions.baselines.train import train
from gym_extensions.errors import BenchError


def told(agent, out) -> str:
    with pytest.raises(BenchError) as mistake:
        train(agent, "hopper-gravity", "sequential", "smoke", 0, out=out)
    return str(mistake.value)


class Blank:
    def __init__(self, observation_space, action_space, seed):
        """Nothing."""


class Mute(Blank):
    def learn(self, env, steps):
        """Nothing."""


class Idle(Blank):
    def act(self, observations):
        return np.zeros((len(observations), 3))


def without_arguments():
    return Idle(None, None, 0)


def still():
    return Still.__new__(Still)


PAGE = "docs/submit.md has one of twenty lines."
FACTORY = (
    "Give a name, or what makes an agent from (observation_space, action_space, seed): the class, "
    "not an agent of it."
)
UNFIT = [
    (
        Idle,
        "Idle: What it makes, of kind Idle, has no method learn. "
        f"Give the agent a method learn(env, steps); {PAGE}",
    ),
    (
        Mute,
        "Mute: What it makes, of kind Mute, has no method act. "
        f"Give the agent a method act(observations); {PAGE}",
    ),
    (
        without_arguments,
        "without_arguments: The factory cannot be called with (observation_space, action_space, seed): "
        "too many positional arguments. Let it take these three.",
    ),
    (still(), f"Still: A value of kind Still is no factory of agents. {FACTORY}"),
    (17, f"int: A value of kind int is no factory of agents. {FACTORY}"),
]


@pytest.mark.parametrize(("agent", "message"), UNFIT, ids=[row[1].partition(":")[0] for row in UNFIT])
def test_what_is_no_agent_is_told_before_anything_is_run(agent, message, tmp_path):
    assert told(agent, tmp_path / "out") == message
    assert not (tmp_path / "out").exists()


def test_a_mistake_inside_the_factory_keeps_its_own_words(tmp_path):
    def broken(observation_space, action_space, seed):
        raise TypeError("mine")

    with pytest.raises(TypeError, match="mine"):
        train(broken, "hopper-gravity", "sequential", "smoke", 0, out=tmp_path)


class Numb(Still):
    """Gives whatever it is told to."""

    given: object = None

    def act(self, observations):
        return self.given


SHAPE = "Give an array of numbers of shape (20, 3), a row a lane."
ACTIONS = [
    (None, "a value of kind NoneType"),
    ("left", "a value of kind str"),
    (0.5, "a value of kind float"),
    (np.zeros((20, 2)), "an array of shape (20, 2) and type float64"),
    (np.zeros(3), "an array of shape (3,) and type float64"),
    ([[0.0] * 3] * 19 + [[0.0]], "a value of kind list"),
    (np.full((20, 3), None), "an array of shape (20, 3) and type object"),
]


@pytest.mark.parametrize(("given", "kind"), ACTIONS, ids=[kind for _, kind in ACTIONS])
def test_what_are_no_actions_is_told_at_the_first(given, kind, tmp_path):
    Numb.given = given
    assert told(Numb, tmp_path) == f"act(): The agent gave {kind} as its actions. {SHAPE}"


def test_actions_of_another_shape_in_training_are_told_too(tmp_path):
    class Narrow(Still):
        def learn(self, env, steps):
            env.reset()
            env.step(np.zeros((env.num_envs, 1)))

    assert told(Narrow, tmp_path) == (
        "env.step() in learn(): The agent gave an array of shape (1, 1) and type float64 as its actions. "
        "Give an array of numbers of shape (1, 3), a row a lane."
    )
