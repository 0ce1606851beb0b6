"""Rules about the characters of the strings in submission.toml, and of README.md."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator

from gym_extensions.rollouts.layout import MANIFEST, README
from gym_extensions.rollouts.manifest import HYPERPARAMETERS
from gym_extensions.rollouts.problem import ROWS_LISTED, Finding, quote
from gym_extensions.rollouts.rules.manifest import Tables, bare, key_path
from gym_extensions.rollouts.rules.rule import rule

INVISIBLE = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Unicode categories of control, format and surrogate characters, and of line and paragraph separators."""
JOINERS = frozenset("\u200c\u200d")
"""Format characters that Persian, Hindi and emoji need."""
BLANK = frozenset("\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\uffa0")
"""Letters and marks without a glyph, with which one text can look like another."""
MAX_MARKS = 5
"""Most combining marks in a row: more leave the line and cover other texts."""
MULTILINE = ("description", HYPERPARAMETERS)
"""Keys whose strings may have line breaks and tabs."""


def _strings(value: object, where: str, multiline: bool = False) -> Iterator[tuple[str, str, bool]]:
    """Every string, keys included, with its location and whether it may have line breaks."""
    if isinstance(value, str):
        yield where, value, multiline
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield where, name, False
            yield from _strings(inner, f"{where}, {bare(name)}", multiline or name in MULTILINE)
    elif isinstance(value, list):
        for inner in value:
            yield from _strings(inner, where, multiline)


def _is_visible(char: str) -> bool:
    """Whether a character has a glyph. Characters that this Python's Unicode does not know are visible."""
    category = unicodedata.category(char)
    return char not in BLANK and (category[0] not in "CMZ" or category == "Cn")


def _first_invisible(text: str) -> str:
    """The first invisible character of a text, or nothing. A joiner counts only between ASCII characters."""
    characters = zip(f" {text}", text, f"{text[1:]} ", strict=False)
    return next((char for before, char, after in characters if _is_invisible(before, char, after)), "")


def _is_invisible(before: str, char: str, after: str) -> bool:
    if char in BLANK:
        return True
    return unicodedata.category(char) in INVISIBLE and (char not in JOINERS or (before + after).isascii())


@rule("manifest")
def empty_title(tables: Tables) -> Iterator[Finding]:
    """The title contains at least one visible character."""
    title = tables.get("title")
    if isinstance(title, str) and not any(map(_is_visible, title)):
        message = f"The title {quote(title)} has no visible character."
        yield Finding(key_path("", "title"), message, "Name the entry.")


def _has_stacked_marks(text: str) -> bool:
    """Whether combining marks are at the start of a text, or more than ``MAX_MARKS`` in a row."""
    if text.isascii():
        return False
    count = MAX_MARKS
    for char in text:
        count = count + 1 if unicodedata.category(char)[0] == "M" else 0
        if count > MAX_MARKS:
            return True
    return False


@rule("manifest")
def stacked_marks(tables: Tables) -> Iterator[Finding]:
    """No string starts with a combining mark or has more than five in a row: they would cover other texts."""
    for where, value, _ in _strings(tables, MANIFEST):
        if _has_stacked_marks(value):
            yield Finding(
                where, f"{quote(value)} has combining marks that cover other texts.", "Remove them."
            )


@rule("manifest")
def control_character(tables: Tables) -> Iterator[Finding]:
    """Strings contain no control, invisible or bidirectional-override characters. (The description and
    hyperparameters may contain line breaks and tabs.)"""
    for where, value, multiline in _strings(tables, MANIFEST):
        text = value.replace("\n", "").replace("\t", "") if multiline else value
        if _first_invisible(text):
            yield Finding(where, f"{quote(value)} contains a control or invisible character.", "Remove it.")


@rule("readme")
def readme_encoding(data: bytes) -> Iterator[Finding]:
    """README.md is UTF-8 text."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        message = f"Byte {data[error.start]:#04x} is not UTF-8."
        yield Finding(f"{README}, line {line}", message, "Save the file as UTF-8.")


@rule("readme")
def readme_character(data: bytes) -> Iterator[Finding]:
    """README.md contains no control, invisible or bidirectional-override characters except line breaks
    and tabs, and no line with stacked combining marks."""
    try:
        lines = data.decode("utf-8").replace("\r\n", "\n").split("\n")
    except UnicodeDecodeError:
        return  # readme_encoding reports it
    characters = [(number, _first_invisible(line.replace("\t", ""))) for number, line in enumerate(lines, 1)]
    invisible = [(number, char) for number, char in characters if char]
    for number, char in invisible[:ROWS_LISTED]:
        message = f"The line contains the control or invisible character U+{ord(char):04X}."
        yield Finding(f"{README}, line {number}", message, "Remove it.")
    stacked = next((number for number, line in enumerate(lines, 1) if _has_stacked_marks(line)), 0)
    if stacked:
        message = "The line has combining marks that cover other texts."
        yield Finding(f"{README}, line {stacked}", message, "Remove them.")
    if more := len(invisible[ROWS_LISTED:]):
        subject = "1 more line contains" if more == 1 else f"{more} more lines contain"
        yield Finding(README, f"{subject} such characters.", "Remove them.")
