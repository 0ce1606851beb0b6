"""The rules of a submission: one function each, its docstring is the rule. ``RULES`` lists them all."""

from gym_extensions.rollouts.rules import (
    consistency,
    csv,
    curves,
    episodes,
    folder,
    manifest,
    measurements,
    npz,
    readable,
    runs,
    unicode,
)
from gym_extensions.rollouts.rules.rule import RULES, broken

__all__ = [
    "RULES",
    "broken",
    "consistency",
    "csv",
    "curves",
    "episodes",
    "folder",
    "manifest",
    "measurements",
    "npz",
    "readable",
    "runs",
    "unicode",
]
