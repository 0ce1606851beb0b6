"""The rules of a submission: one function each, its docstring is the rule. ``RULES`` lists them all."""

from gym_extensions.scoring.checks import (
    across,
    agreement,
    arrays,
    curves,
    files,
    keys,
    manifest,
    reading,
    text,
    texts,
    values,
)
from gym_extensions.scoring.checks.rule import RULES, broken

__all__ = [
    "RULES",
    "across",
    "agreement",
    "arrays",
    "broken",
    "curves",
    "files",
    "keys",
    "manifest",
    "reading",
    "text",
    "texts",
    "values",
]
