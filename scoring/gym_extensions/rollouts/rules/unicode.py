"""Rules about what the texts of submission.toml show."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator

from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.manifest import FREE
from gym_extensions.rollouts.problem import Finding, shown
from gym_extensions.rollouts.rules.manifest import Tables, bare, key
from gym_extensions.rollouts.rules.rule import rule

UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Unicode categories of control and format characters, halves of pairs, and ends of lines and paragraphs."""
JOINING = frozenset("\u200c\u200d")
"""Format characters that Persian, Hindi and emoji are written with."""
BLANK = frozenset("\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\uffa0")
"""Letters and marks that show nothing: with them a text can look like another."""


def _texts(value: object, place: str, broken: bool = False) -> Iterator[tuple[str, str, bool]]:
    """Every text with its place, and whether it may have line breaks."""
    if isinstance(value, str):
        yield place, value, broken
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield place, name, False
            yield from _texts(inner, f"{place}, {bare(name)}", broken or name in ("description", FREE))
    elif isinstance(value, list):
        for inner in value:
            yield from _texts(inner, place, broken)


def _shows(one: str) -> bool:
    """Whether a character leaves ink; one that this Python's Unicode does not know yet does."""
    category = unicodedata.category(one)
    return one not in BLANK and (category[0] not in "CMZ" or category == "Cn")


def _unseen(text: str) -> bool:
    """Whether a text holds such a character; a joiner is one between characters of ASCII."""
    return any(
        one in BLANK
        or (unicodedata.category(one) in UNSEEN and (one not in JOINING or (before + after).isascii()))
        for before, one, after in zip(f" {text}", text, f"{text[1:]} ", strict=False)
    )


@rule("manifest")
def empty_title(tables: Tables) -> Iterator[Finding]:
    """The title shows something."""
    title = tables.get("title")
    if isinstance(title, str) and not any(_shows(one) for one in title):
        yield Finding(key("", "title"), f"The title {shown(title)} shows nothing.", "Name the entry.")


@rule("manifest")
def control_character(tables: Tables) -> Iterator[Finding]:
    """Texts hold nothing that a terminal would obey, that cannot be seen, or that turns what follows.

    (The description and hyperparameters may have line breaks and tabs.)
    """
    for place, value, broken in _texts(tables, MANIFEST):
        text = value.replace("\n", "").replace("\t", "") if broken else value
        if _unseen(text):
            yield Finding(place, f"The text {shown(value)} holds an unseen character.", "Remove it.")
