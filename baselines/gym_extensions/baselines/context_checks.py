"""Checks of what an agent asks to observe, and the call of its ``act`` with a context."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import fields

from gym_extensions.baselines.agent import Agent, Array, Context, Observes
from gym_extensions.errors import BenchError

CONTEXT = "context"
"""The parameter of ``act`` that receives the context."""


def observes_of(agent: Agent, name: str) -> Observes:
    """What the agent asks for in its attribute ``observes``; nothing if it has none.

    Raises:
        BenchError: the attribute is not an ``Observes``, or a field is not True or False.
    """
    observes: object = getattr(agent, "observes", Observes())
    if not isinstance(observes, Observes):
        message = f"The agent's attribute observes is of type {type(observes).__name__}."
        hint = "Use a gym_extensions.baselines.Observes."
        raise BenchError("bad-agent", message, name, hint)
    for item in fields(observes):
        value: object = getattr(observes, item.name)
        if not isinstance(value, bool):
            message = f"The agent's observes.{item.name} is {value!r}."
            raise BenchError("bad-agent", message, name, "Use True or False.")
    return observes


def action_function(agent: Agent) -> Callable[[Array, Context], Array]:
    """The agent's ``act`` as a function of observations and context, whether or not it uses the context."""
    parameter = _context_parameter(_parameters(agent))
    if parameter is None:
        return lambda observations, _: agent.act(observations)
    if parameter.kind is parameter.KEYWORD_ONLY:
        return lambda observations, context: agent.act(observations, context=context)
    return agent.act


def check_context(agent: Agent, name: str) -> None:
    """Checks that the agent can receive what it asks for.

    Raises:
        BenchError: ``observes`` is not valid, ``act`` requires another argument, or the agent asks for the
            task in evaluation and ``act`` has no parameter for the context.
    """
    parameters = _parameters(agent)
    context = _context_parameter(parameters)
    for parameter in parameters[1:]:
        variadic = parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
        if parameter is not context and parameter.default is parameter.empty and not variadic:
            message = f"act() requires the argument {parameter.name!r}."
            hint = "Use act(observations) or act(observations, context)."
            raise BenchError("bad-agent", message, name, hint)
    if observes_of(agent, name).task_in_evaluation and context is None:
        message = "The agent asks for task_in_evaluation, but act() does not receive the context."
        raise BenchError("bad-agent", message, name, "Use act(observations, context).")


def _parameters(agent: Agent) -> list[inspect.Parameter]:
    try:
        return list(inspect.signature(agent.act).parameters.values())
    except ValueError:  # a builtin without a signature
        return []


def _context_parameter(parameters: Sequence[inspect.Parameter]) -> inspect.Parameter | None:
    """The second parameter of ``act``, unless it is optional and has another name than ``context``."""
    for parameter in parameters[1:2]:
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            return None
        is_required = parameter.default is parameter.empty and parameter.kind is not parameter.KEYWORD_ONLY
        if is_required or parameter.name == CONTEXT:
            return parameter
    return None
