"""Checks of a factory, its agent and the agent's card, made before training starts."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import gymnasium as gym

from gym_extensions.baselines.agent import Agent, Card, Described, Factory
from gym_extensions.baselines.context_checks import check_context
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.installed import version_or_none
from gym_extensions.rollouts.manifest import SECTIONS
from gym_extensions.rollouts.manifest_values import (
    HYPERPARAMETER,
    NAMES,
    Key,
    hyperparameter_error,
    value_error,
)

METHODS = {"act": "act(observations)", "learn": "learn(env, steps)"}
"""The required methods of an agent and their signatures."""
ARGUMENTS = "(observation_space, action_space, seed)"
KEYS: dict[str, Key] = {
    "algorithm": SECTIONS["protocol"]["algorithm"],
    "title": SECTIONS[""]["title"],
    "description": SECTIONS[""]["description"],
    "evaluation": SECTIONS["protocol"]["evaluation"],
    "tuning_steps": SECTIONS["tuning"]["steps"],
    "tuning_tasks": SECTIONS["tuning"]["tasks"],
    "stored_steps": SECTIONS["memory"]["stored_steps"],
    "parameters": SECTIONS["memory"]["parameters_last"],
    "packages": Key(NAMES),
}
"""The key of submission.toml that each field of a card becomes; the names of packages become keys."""


def create_agent(make: Factory, spaces: tuple[gym.Space[Any], gym.Space[Any]], name: str) -> Agent:
    """Creates an agent with seed 0 to check that the factory and the agent fit the training loop.

    Args:
        make: the value that was passed as a factory.
        spaces: the observation and the action space.
        name: the agent's name, for error messages.

    Raises:
        BenchError: ``make`` is not a factory, the agent lacks a method, ``act`` needs other arguments, or
            ``observes`` is not valid.
    """
    _check_factory(make, name)
    agent = make(*spaces, 0)
    for method, signature in METHODS.items():
        if not callable(getattr(agent, method, None)):
            message = f"The agent, of type {_type(agent)}, has no method {method}()."
            hint = f"Add a method {signature}; docs/submit.md has an example."
            raise BenchError("bad-agent", message, name, hint)
    check_context(agent, name)
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
    """The agent's card, checked.

    If the agent has none, a card with only ``name``.

    Raises:
        BenchError: the card holds a value that the manifest does not allow.
    """
    card: object = agent.card() if isinstance(agent, Described) else Card(algorithm=name)
    if not isinstance(card, Card):
        raise _bad_card(f"Expected a Card, got {_type(card)}.", "Return a gym_extensions.baselines.Card.")
    _check_fields(card)
    if not card.algorithm.strip():
        raise _bad_card("The algorithm has no name.", "Give a name, such as 'SAC'.")
    settings: object = card.hyperparameters
    if not isinstance(settings, Mapping):
        raise _bad_card(f"hyperparameters is of type {_type(settings)}.", "Use a dict of values by name.")
    for key, value in settings.items():
        if not isinstance(key, str):
            raise _bad_card(f"The hyperparameter name {key!r} is not a string.", "Use strings as names.")
        if problem := hyperparameter_error(value):
            hint = f"Use {HYPERPARAMETER}."
            raise BenchError("bad-setting", f"Hyperparameter {key!r} {problem}.", "card()", hint)
    return card


def _check_fields(card: Card) -> None:
    for name, key in KEYS.items():
        value = getattr(card, name)
        value = list(value) if isinstance(value, tuple) else value
        if error := value_error(key, value):
            raise BenchError("bad-card", error, f"card().{name}", f"Give {key.wanted}.")
        if key.choices and value not in key.choices:
            hint = did_you_mean(str(value), map(str, key.choices))
            raise BenchError("bad-card", f"The value is {value!r}.", f"card().{name}", hint)
    for package in card.packages:
        if package in SECTIONS["versions"]:
            message, hint = f"The manifest always states the version of {package!r}.", "Leave it out."
        elif version_or_none(package) is None:
            message, hint = f"The package {package!r} is not installed.", "Use the names that pip lists."
        else:
            continue
        raise BenchError("bad-card", message, "card().packages", hint)


def _bad_card(message: str, hint: str) -> BenchError:
    return BenchError("bad-card", message, "card()", hint)


def _type(value: object) -> str:
    return type(value).__name__
