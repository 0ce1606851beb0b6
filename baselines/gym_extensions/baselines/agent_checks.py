"""Checks of a factory, its agent and the agent's card, made before training starts."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from typing import Any

import gymnasium as gym

from gym_extensions.baselines.agent import Agent, Card, Described, Factory
from gym_extensions.errors import BenchError, did_you_mean

METHODS = {"act": "act(observations)", "learn": "learn(env, steps)"}
"""The required methods of an agent and their signatures."""
ARGUMENTS = "(observation_space, action_space, seed)"
EVALUATIONS = ("sampled", "deterministic")
"""How an agent acts in evaluation."""
MAX_CHARACTERS = {"algorithm": 100, "title": 100, "description": 4000}
FLAGS = ("task_in_training", "task_in_evaluation", "boundaries")
COUNTS = ("stored_steps", "parameters")
MAX_SETTING_CHARACTERS, MAX_SETTING_ELEMENTS = 4000, 100
SETTING_HINT = "Use a string, a finite number, a boolean, or a list of them."


def create_agent(make: Factory, spaces: tuple[gym.Space[Any], gym.Space[Any]], name: str) -> Agent:
    """Creates an agent with seed 0 to check that the factory and the agent fit the training loop.

    Args:
        make: the value that was passed as a factory.
        spaces: the observation and the action space.
        name: the agent's name, for error messages.

    Raises:
        BenchError: ``make`` is not a factory, or the agent lacks a method.
    """
    _check_factory(make, name)
    agent = make(*spaces, 0)
    for method, signature in METHODS.items():
        if not callable(getattr(agent, method, None)):
            message = f"The agent, of type {_type(agent)}, has no method {method}()."
            hint = f"Add a method {signature}; docs/submit.md has an example."
            raise BenchError("bad-agent", message, name, hint)
    return agent


def _check_factory(make: object, name: str) -> None:
    is_agent = not isinstance(make, type) and any(hasattr(make, method) for method in METHODS)
    if is_agent or not callable(make):
        message = f"Expected a factory of agents, got a value of type {_type(make)}."
        hint = f"Pass an agent's name, or a class or function with the arguments {ARGUMENTS}."
        raise BenchError("bad-agent", message, name, hint)
    try:
        inspect.signature(make).bind(None, None, 0)
    except TypeError as mismatch:
        message = f"The factory cannot be called with {ARGUMENTS}: {mismatch}."
        raise BenchError("bad-agent", message, name, "Give it these three arguments.") from mismatch
    except ValueError:
        return  # a builtin without a signature


def card_of(agent: Agent, name: str) -> Card:
    """The agent's card, checked; a card with only ``name`` if the agent has none.

    Raises:
        BenchError: the card holds a value that the manifest does not allow.
    """
    card: object = agent.card() if isinstance(agent, Described) else Card(algorithm=name)
    if not isinstance(card, Card):
        raise _bad_card(f"Expected a Card, got {_type(card)}.", "Return a gym_extensions.baselines.Card.")
    _check_fields(card)
    settings: object = card.hyperparameters
    if not isinstance(settings, Mapping):
        raise _bad_card(f"hyperparameters is of type {_type(settings)}.", "Use a dict of values by name.")
    for key, value in settings.items():
        if not isinstance(key, str):
            raise _bad_card(f"The hyperparameter name {key!r} is not a string.", "Use strings as names.")
        if problem := setting_problem(value):
            raise BenchError("bad-setting", f"Hyperparameter {key!r} {problem}.", "card()", SETTING_HINT)
    return card


def _check_fields(card: Card) -> None:
    for name, limit in MAX_CHARACTERS.items():
        text = getattr(card, name)
        if not isinstance(text, str):
            raise _bad_card(f"{name} is of type {_type(text)}.", "Use a string.")
        if len(text) > limit:
            raise _bad_card(f"{name} has {len(text)} characters.", f"Use at most {limit}.")
    if card.evaluation not in EVALUATIONS:
        raise _bad_card(
            f"evaluation is {card.evaluation!r}.", did_you_mean(str(card.evaluation), EVALUATIONS)
        )
    for name in FLAGS:
        if not isinstance(getattr(card, name), bool):
            raise _bad_card(f"{name} is {getattr(card, name)!r}.", "Use True or False.")
    for name in COUNTS:
        count = getattr(card, name)
        if not isinstance(count, int) or isinstance(count, bool) or not 0 <= count < 2**53:
            raise _bad_card(f"{name} is {count!r}.", "Use an int that is not negative.")


def _bad_card(message: str, hint: str) -> BenchError:
    return BenchError("bad-card", message, "card()", hint)


def setting_problem(value: Any, nested: bool = False) -> str:
    """Why a value cannot be a hyperparameter, or an empty string."""
    if isinstance(value, list | tuple) and not nested:
        if len(value) > MAX_SETTING_ELEMENTS:
            return f"has {len(value)} elements; the limit is {MAX_SETTING_ELEMENTS}"
        return next(filter(None, (setting_problem(element, True) for element in value)), "")
    if isinstance(value, str):
        too_long = len(value) > MAX_SETTING_CHARACTERS
        return f"has {len(value)} characters; the limit is {MAX_SETTING_CHARACTERS}" if too_long else ""
    if isinstance(value, float):
        return "" if math.isfinite(value) else f"is {value!r}"
    if isinstance(value, int):
        return "" if abs(value) < 2**63 else "does not fit in 64 bits"
    return f"has an element of type {_type(value)}" if nested else f"is of type {_type(value)}"


def _type(value: object) -> str:
    return type(value).__name__
