"""What an agent must be before anything is trained: made by a factory, with what the loop calls."""

from __future__ import annotations

import inspect
from typing import Any

import gymnasium as gym

from gym_extensions.baselines.agent import Agent, Factory
from gym_extensions.errors import BenchError

NEEDED = {"act": "act(observations)", "learn": "learn(env, steps)"}
"""Methods that every agent has, and how they are called."""
ARGUMENTS = "(observation_space, action_space, seed)"


def fit_agent(make: Factory, spaces: tuple[gym.Space[Any], gym.Space[Any]], name: str) -> Agent:
    """An agent for the spaces that nothing is trained with: only its kind and its card are looked at.

    Args:
        make: what was given as the factory.
        spaces: of observations and of actions.
        name: what the agent is called, for an error.

    Raises:
        BenchError: this is no factory, or what it makes lacks a method.
    """
    _refuse_what_makes_nothing(make, name)
    agent = make(*spaces, 0)
    for method, call in NEEDED.items():
        if not callable(getattr(agent, method, None)):
            message = f"What it makes, of kind {type(agent).__name__}, has no method {method}."
            hint = f"Give the agent a method {call}; docs/submit.md has one of twenty lines."
            raise BenchError("bad-agent", message, name, hint)
    return agent


def _refuse_what_makes_nothing(make: object, name: str) -> None:
    ready = not isinstance(make, type) and any(hasattr(make, method) for method in NEEDED)
    if ready or not callable(make):
        message = f"A value of kind {type(make).__name__} is no factory of agents."
        hint = f"Give a name, or what makes an agent from {ARGUMENTS}: the class, not an agent of it."
        raise BenchError("bad-agent", message, name, hint)
    try:
        inspect.signature(make).bind(None, None, 0)
    except TypeError as mistake:
        message = f"The factory cannot be called with {ARGUMENTS}: {mistake}."
        raise BenchError("bad-agent", message, name, "Let it take these three.") from mistake
    except ValueError:
        return  # it tells nobody what it takes
