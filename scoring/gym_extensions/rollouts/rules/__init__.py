"""The rules of a submission: one function per rule, whose docstring is the rule. ``RULES`` lists them all."""

from gym_extensions.rollouts.rules import (
    consistency,
    csv,
    curves,
    episodes,
    folder,
    manifest,
    measurements,
    npz,
    runs,
    unicode,
)
from gym_extensions.rollouts.rules.rule import RULES, problems

__all__ = [
    "RULES",
    "consistency",
    "csv",
    "curves",
    "episodes",
    "folder",
    "manifest",
    "measurements",
    "npz",
    "problems",
    "runs",
    "unicode",
]
