"""What an agent's card may say: the facts that a submission's manifest takes, checked before training."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from gym_extensions.baselines.agent import Agent, Card, Described
from gym_extensions.errors import BenchError, did_you_mean

EVALUATIONS = ("sampled", "deterministic")
"""How an agent acts while it is evaluated."""
LONGEST = {"algorithm": 100, "title": 100, "description": 4000}
"""Characters of each text."""
FLAGS = ("task_in_training", "task_in_evaluation", "boundaries")
COUNTS = ("stored_steps", "parameters")
LONGEST_SETTING, MOST_ELEMENTS = 4000, 100
PLAIN = "Give a text, a finite number, true or false, or a list of them."


def card_of(agent: Agent, name: str) -> Card:
    """The agent's own card, or one that knows only its name.

    Raises:
        BenchError: the card says what no manifest takes; a submission with it would be refused.
    """
    card: object = agent.card() if isinstance(agent, Described) else Card(algorithm=name)
    if not isinstance(card, Card):
        hint = "Return a gym_extensions.baselines.agent.Card."
        raise BenchError("bad-card", f"The agent's card is of kind {_kind(card)}.", "card()", hint)
    _check_words(card)
    settings: object = card.hyperparameters
    if not isinstance(settings, Mapping):
        found = f"hyperparameters is of kind {_kind(settings)}."
        raise BenchError("bad-card", found, "card()", "Give a dict of settings by name.")
    for key, value in settings.items():
        if unfit := _unfit_name(key) or unfit_setting(value):
            hint = PLAIN if isinstance(key, str) else "Name each setting by a text."
            raise BenchError("bad-setting", f"The hyperparameter {key!r} {unfit}.", "card()", hint)
    return card


def _check_words(card: Card) -> None:
    for name, longest in LONGEST.items():
        text = getattr(card, name)
        if not isinstance(text, str) or len(text) > longest:
            found = f"{name} is no text of at most {longest} characters."
            raise BenchError("bad-card", found, "card()", "Give a shorter text.")
    if card.evaluation not in EVALUATIONS:
        hint = did_you_mean(str(card.evaluation), EVALUATIONS)
        raise BenchError("bad-card", f"evaluation is {card.evaluation!r}.", "card()", hint)
    for name in FLAGS:
        if not isinstance(getattr(card, name), bool):
            found = f"{name} is {getattr(card, name)!r}."
            raise BenchError("bad-card", found, "card()", "Give True or False.")
    for name in COUNTS:
        count = getattr(card, name)
        if not isinstance(count, int) or isinstance(count, bool) or not 0 <= count < 2**53:
            raise BenchError("bad-card", f"{name} is {count!r}.", "card()", "Give an int from 0.")


def _unfit_name(key: object) -> str:
    return "" if isinstance(key, str) else "has no text for a name"


def unfit_setting(value: Any, inside: bool = False) -> str:
    """Why a value cannot be a hyperparameter; empty where it can."""
    if isinstance(value, list | tuple) and not inside:
        if len(value) > MOST_ELEMENTS:
            return f"has {len(value)} elements; {MOST_ELEMENTS} are allowed"
        return next(filter(None, (unfit_setting(one, True) for one in value)), "")
    if isinstance(value, str):
        length = len(value)
        return f"has {length} characters; {LONGEST_SETTING} are allowed" if length > LONGEST_SETTING else ""
    if isinstance(value, float):
        return "" if math.isfinite(value) else f"is {value!r}"
    if isinstance(value, int):
        return "" if abs(value) < 2**63 else "is too large"
    return f"holds a value of kind {_kind(value)}" if inside else f"is of kind {_kind(value)}"


def _kind(value: object) -> str:
    return type(value).__name__
