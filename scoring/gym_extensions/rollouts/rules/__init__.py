"""The rules of a submission are functions whose docstrings are the published text.

``RULES`` lists them all.
"""

from gym_extensions.rollouts.rules import (
    consistency,
    csv,
    curves,
    episodes,
    folder,
    manifest,
    measurements,
    npz,
    policies,
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
    "policies",
    "problems",
    "runs",
    "unicode",
]
