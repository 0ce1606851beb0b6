"""Checks of a factory, its agent and the agent's card, made before training starts."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import gymnasium as gym
import msgspec
from msgspec.structs import asdict, astuple

from gym_extensions.baselines.agent import Agent, Array, Card, Context, Described, Factory
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.errors import BenchError
from gym_extensions.submissions.layout import MANIFEST, Folder
from gym_extensions.submissions.manifest import FORMAT, Observes
from gym_extensions.submissions.rules import problems
from gym_extensions.submissions.run import Count, Versions
from gym_extensions.versions import version_or_none

CARD_TYPES: dict[str, Any] = {
    "algorithm": str,
    "hyperparameters": dict[str, Any],
    **dict.fromkeys(("tuning_tasks", "packages"), tuple[str, ...]),
    **dict.fromkeys(("stored_steps", "parameters"), Count),
}
"""The types of what ``submission.toml`` does not hold, or holds in another way."""
NO_FOLDER = Folder(Path("card"), "card", (), {})
"""The rules look at the tables only."""
VARIADIC = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def observes_of(agent: Agent, name: str) -> Observes:
    """What the agent asks for in its attribute ``observes``; nothing if it has none.

    Raises ``BenchError`` if the attribute is not an ``Observes`` of booleans.
    """
    observes: object = getattr(agent, "observes", Observes())
    if not isinstance(observes, Observes) or not all(isinstance(each, bool) for each in astuple(observes)):
        message = f"The agent's attribute observes is {observes!r}."
        hint = "Use a gym_extensions.baselines.Observes, with True or False."
        raise BenchError("bad-agent", message, name, hint)
    return observes


def action_function(agent: Agent) -> Callable[[Array, Context], Array]:
    """The agent's ``act`` as a function of observations and context, whether or not it uses the context."""
    parameter = _context_parameter(agent)
    if parameter is None:
        return lambda observations, _: agent.act(observations)
    if parameter.kind is parameter.KEYWORD_ONLY:
        return lambda observations, context: agent.act(observations, context=context)
    return agent.act


def _context_parameter(agent: Agent) -> inspect.Parameter | None:
    """The second parameter of ``act``, unless it is optional and has another name than ``context``."""
    for parameter in list(inspect.signature(agent.act).parameters.values())[1:2]:
        if parameter.kind in VARIADIC:
            return None
        is_required = parameter.default is parameter.empty and parameter.kind is not parameter.KEYWORD_ONLY
        if is_required or parameter.name == "context":
            return parameter
    return None


def check_context(agent: Agent, name: str) -> None:
    """Checks that the agent can receive what it asks for.

    Raises ``BenchError`` if ``observes`` is not valid, ``act`` requires another argument, or the agent asks
    for the task in evaluation and ``act`` has no parameter for the context.
    """
    context, message = _context_parameter(agent), ""
    for parameter in list(inspect.signature(agent.act).parameters.values())[1:]:
        is_optional = parameter.default is not parameter.empty or parameter.kind in VARIADIC
        if not is_optional and parameter != context:
            message = f"act() requires the argument {parameter.name!r}."
    if observes_of(agent, name).task_in_evaluation and context is None:
        message = "The agent asks for task_in_evaluation, but act() does not receive the context."
    if message:
        hint = "Use act(observations) or act(observations, context)."
        raise BenchError("bad-agent", message, name, hint)


METHODS = {"act": "act(observations)", "learn": "learn(env, steps)"}
"""The required methods of an agent and their signatures."""
SB3_MODULES = ("stable_baselines3.", "sb3_contrib.", "sbx.")
ARGUMENTS = "(observation_space, action_space, seed)"


def create_agent(make: Factory, spaces: tuple[gym.Space[Any], gym.Space[Any]], name: str) -> Agent:
    """Creates an agent with seed 0 to check that the factory and the agent fit the training loop.

    Raises ``BenchError`` if ``make`` is not a factory, the agent lacks a method, ``act`` needs other
    arguments, or ``observes`` is not valid. It names ``name``.
    """
    is_agent = not isinstance(make, type) and any(hasattr(make, method) for method in METHODS)
    if is_agent or not callable(make):
        message = f"Expected a factory of agents, got a value of type {type(make).__name__}."
        hint = f"Pass an agent's name, or a class or function with the arguments {ARGUMENTS}."
        raise BenchError("bad-agent", message, name, hint)
    if isinstance(make, type) and make.__module__.startswith(SB3_MODULES):
        message = f"{make.__name__} is an algorithm of Stable-Baselines3, not an agent."
        raise BenchError("bad-agent", message, name, f"Pass sb3({make.__name__}).")
    try:
        inspect.signature(make).bind(None, None, 0)
    except TypeError as mismatch:
        message = f"The factory cannot be called with {ARGUMENTS}: {mismatch}."
        raise BenchError("bad-agent", message, name, "Give it these three arguments.") from mismatch
    agent = make(*spaces, 0)
    for method, signature in METHODS.items():
        if not callable(getattr(agent, method, None)):
            message = f"The agent, of type {type(agent).__name__}, has no method {method}()."
            hint = f"Add a method {signature}; docs/submit.md has an example."
            raise BenchError("bad-agent", message, name, hint)
    check_context(agent, name)
    return agent


def card_of(agent: Agent, name: str) -> Card:
    """The agent's card, checked by the rules of ``submission.toml``.

    If the agent has none, a card with only ``name``.

    Raises ``BenchError`` if scoring would refuse a value, or a package is not installed.
    """
    card: object = agent.card() if isinstance(agent, Described) else Card(algorithm=name)
    if not isinstance(card, Card):
        message = f"Expected a Card, got {type(card).__name__}."
        raise BenchError("bad-card", message, "card()", "Return a gym_extensions.baselines.Card.")
    for field, kind in CARD_TYPES.items():
        try:
            msgspec.convert(getattr(card, field), kind)
        except msgspec.ValidationError as error:
            raise _bad_card(field, f"The value is {getattr(card, field)!r}: {error}.") from error
    if not card.algorithm.strip():
        raise _bad_card("algorithm", "The algorithm has no name.")
    tables = card_tables(card, Observes())
    tables["protocol"]["budget"] = STANDARD_BUDGET
    for problem in problems("manifest", NO_FOLDER, tables):
        if problem.rule != "no-groups":
            raise _bad_card(problem.where.removeprefix(f"{MANIFEST}, "), problem.message, problem.hint)
    for package in card.packages:
        if package in Versions.__struct_fields__:
            raise _bad_card("packages", f"Every run states the version of {package!r}.", "Leave it out.")
        if version_or_none(package) is None:
            hint = "Use the names that pip lists."
            raise _bad_card("packages", f"The package {package!r} is not installed.", hint)
    return card


def card_tables(card: Card, observes: Observes) -> dict[str, Any]:
    """The sections of ``submission.toml`` that follow from a card, with values as TOML reads them back."""
    settings: Mapping[str, Any] = card.hyperparameters
    parent = {"parent": card.parent} if card.parent else {}
    return {
        "format": FORMAT,
        "title": card.title or card.algorithm,
        "authors": [],
        "description": card.description,
        "code": {"url": "", "commit": ""},
        "protocol": {"algorithm": card.algorithm, "evaluation": card.evaluation} | parent,
        "hyperparameters": {
            key: list(value) if isinstance(value, tuple) else value for key, value in settings.items()
        },
        "observes": asdict(observes),
        "tuning": {"steps": card.tuning_steps, "tasks": list(card.tuning_tasks)},
    }


def _bad_card(where: str, message: str, hint: str = "See gym_extensions.baselines.Card.") -> BenchError:
    return BenchError("bad-card", message, f"card(): {where}", hint)
