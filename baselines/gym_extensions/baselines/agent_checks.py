"""What an agent's card may say: the facts that a submission's manifest takes, checked before training."""

from __future__ import annotations

from collections.abc import Mapping

from gym_extensions.baselines.agent import Agent, Card, Described
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.rollouts.manifest import SECTIONS
from gym_extensions.rollouts.manifest_values import HYPERPARAMETER, Key, hyperparameter_error, value_error

KEYS: dict[str, Key] = {
    "algorithm": SECTIONS["protocol"]["algorithm"],
    "title": SECTIONS[""]["title"],
    "description": SECTIONS[""]["description"],
    "evaluation": SECTIONS["protocol"]["evaluation"],
    **SECTIONS["observes"],
    "stored_steps": SECTIONS["memory"]["stored_steps"],
    "parameters": SECTIONS["memory"]["parameters_last"],
}
"""The key of submission.toml that each field of a card becomes."""


def card_of(agent: Agent, name: str) -> Card:
    """The agent's own card, or one that knows only its name.

    Raises:
        BenchError: the card says what no manifest takes; a submission with it would be refused.
    """
    card: object = agent.card() if isinstance(agent, Described) else Card(algorithm=name)
    if not isinstance(card, Card):
        hint = "Return a gym_extensions.baselines.agent.Card."
        raise BenchError("bad-card", f"The agent's card is of kind {_kind(card)}.", "card()", hint)
    _check_fields(card)
    settings: object = card.hyperparameters
    if not isinstance(settings, Mapping):
        found = f"hyperparameters is of kind {_kind(settings)}."
        raise BenchError("bad-card", found, "card()", "Give a dict of settings by name.")
    for key, value in settings.items():
        if unfit := _unfit_name(key) or hyperparameter_error(value):
            hint = f"Give {HYPERPARAMETER}." if isinstance(key, str) else "Name each setting by a text."
            raise BenchError("bad-setting", f"The hyperparameter {key!r} {unfit}.", "card()", hint)
    return card


def _check_fields(card: Card) -> None:
    for name, key in KEYS.items():
        value = getattr(card, name)
        if error := value_error(key, value):
            raise BenchError("bad-card", error, f"card().{name}", f"Give {key.kind}.")
        if key.choices and value not in key.choices:
            hint = did_you_mean(str(value), map(str, key.choices))
            raise BenchError("bad-card", f"The value is {value!r}.", f"card().{name}", hint)


def _unfit_name(key: object) -> str:
    return "" if isinstance(key, str) else "has no text for a name"


def _kind(value: object) -> str:
    return type(value).__name__
