"""The experts: for a MuJoCo task one frozen policy that numpy evaluates, and a card of its origin.

Example:
    >>> from gym_extensions import experts
    >>> policy = experts.load("HopperGravityHalf")
    >>> policy.num_inputs
    11
"""

from gym_extensions.experts.cards import (
    DATA,
    EPISODES,
    Card,
    Measurement,
    Origin,
    RecordCard,
    Step,
    beats_floor,
    card,
    digest,
    load,
    names,
    origins,
    read_policy,
    seed,
    write,
    write_policy,
)

__all__ = [
    "DATA",
    "EPISODES",
    "Card",
    "Measurement",
    "Origin",
    "RecordCard",
    "Step",
    "beats_floor",
    "card",
    "digest",
    "load",
    "names",
    "origins",
    "read_policy",
    "seed",
    "write",
    "write_policy",
]
