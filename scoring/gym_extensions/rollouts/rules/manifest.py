"""Rules about submission.toml. Each looks at its parsed tables."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.published import TABLES
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.manifest import (
    COUNT,
    DEEPEST,
    DIGEST,
    FLAG,
    FREE,
    LONG,
    NAMES,
    OPTIONAL_SECTIONS,
    REPORTED_LACKS,
    SECTIONS,
    SHORT,
    TEXT,
    URL,
    parse,
)
from gym_extensions.rollouts.problem import LONGEST_QUOTE, Finding, shown
from gym_extensions.rollouts.rules.rule import rule

Tables = dict[str, Any]
BARE = re.compile(r"[A-Za-z0-9_-]{1,80}")
WEB = re.compile(r"(https?://[^\s<>\"'/@]+(/[^\s<>\"']*)?)?")


def bare(name: str) -> str:
    """A key as it is written without quotes, or quoted."""
    return name if BARE.fullmatch(name) else shown(name)


def key(section: str, name: str) -> str:
    return f"{MANIFEST}, {f'[{section}] ' if section else ''}{bare(name)}"


def _close(name: str, choices: Iterable[str]) -> str:
    return did_you_mean(name[:LONGEST_QUOTE], choices)


@rule("manifest-bytes")
def malformed_toml(data: bytes) -> Iterator[Finding]:
    """submission.toml is TOML in UTF-8, with few tables and lists in one another."""
    try:
        parse(data)
    except ValueError as mistake:
        hint = "Correct that place; the format is at https://toml.io."
        yield Finding(MANIFEST, f"It is not TOML: {str(mistake)[:200]}.", hint)
    except RecursionError:
        hint = f"At most {DEEPEST} may stand in one another."
        yield Finding(MANIFEST, "Its tables or lists are nested too deeply.", hint)


@rule("manifest")
def unknown_key(tables: Tables) -> Iterator[Finding]:
    """Every section and key of submission.toml is one of the format's; [hyperparameters] alone is free."""
    for name in tables:
        if name not in SECTIONS and name not in SECTIONS[""]:
            hint = _close(name, [*filter(None, SECTIONS), *SECTIONS[""]]) or "Remove it."
            yield Finding(MANIFEST, f"There is no key {shown(name)}.", hint)
    for section, fields in SECTIONS.items():
        given = tables.get(section) if section and section != FREE else None
        for name in given if isinstance(given, dict) else ():
            if name not in fields:
                yield Finding(key(section, name), f"There is no key {shown(name)}.", _close(name, fields))


@rule("manifest")
def missing_key(tables: Tables) -> Iterator[Finding]:
    """Every required section and key of submission.toml is there."""
    lacking = (*OPTIONAL_SECTIONS, *(REPORTED_LACKS if "reported" in tables else ()))
    for section, fields in SECTIONS.items():
        if section in lacking and section not in tables:
            continue
        given = tables.get(section, {}) if section else tables
        for name, field in fields.items():
            if field.required and isinstance(given, dict) and name not in given:
                yield Finding(
                    key(section, name), "The key is missing.", f"Add {name} with a value: {field.kind}."
                )


def _count(value: object, longest: int) -> str:
    whole = isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**53
    return "" if whole else f"{shown(value)} is not a whole number from 0 to 2⁵³ − 1."


def _flag(value: object, longest: int) -> str:
    return "" if isinstance(value, bool) else f"{shown(value)} is not true or false."


def _names(value: object, longest: int) -> str:
    names = value if isinstance(value, list) and len(value) <= SHORT else [None]
    good = all(isinstance(name, str) and 0 < len(name) <= longest for name in names)
    return "" if good else f"{shown(value)} is not a list of texts of 1 to {longest} characters."


def _text(value: object, longest: int) -> str:
    if not isinstance(value, str):
        return f"{shown(value)} is not a text."
    return "" if len(value) <= longest else f"It has {len(value)} characters; the limit is {longest}."


def _url(value: object, longest: int) -> str:
    wrong = _text(value, longest)
    web = isinstance(value, str) and WEB.fullmatch(value)
    return (
        wrong if wrong or web else f"{shown(value)} is not an address that begins with https:// or http://."
    )


def _digest(value: object, longest: int) -> str:
    good = isinstance(value, str) and re.fullmatch("([0-9a-f]{64})?", value)
    return "" if good else f"{shown(value)} is not 64 digits of 0 to 9 and a to f."


WRONG: dict[str, Callable[[object, int], str]] = {
    COUNT: _count,
    DIGEST: _digest,
    FLAG: _flag,
    NAMES: _names,
    TEXT: _text,
    URL: _url,
}
"""What is wrong with a value of each kind, or nothing."""


@rule("manifest")
def bad_value(tables: Tables) -> Iterator[Finding]:
    """Every value of submission.toml is of the kind that its key takes; a section is a table."""
    for section, fields in SECTIONS.items():
        given = tables.get(section, {}) if section else tables
        if not isinstance(given, dict):
            yield Finding(
                f"{MANIFEST}, {section}",
                f"{shown(given)} is not a section.",
                f"Write [{section}] and its keys.",
            )
            continue
        for name, field in fields.items():
            wrong = WRONG[field.kind](given[name], field.longest) if name in given else ""
            if wrong:
                yield Finding(key(section, name), wrong, f"Give {field.kind}.")
            elif name in given and field.choices and given[name] not in field.choices and name != "budget":
                choices = [str(choice) for choice in field.choices]
                yield Finding(
                    key(section, name),
                    f"The value is {shown(given[name])}.",
                    did_you_mean(str(given[name]), choices),
                )


@rule("manifest")
def unknown_budget(tables: Tables) -> Iterator[Finding]:
    """The budget is one of the published ones."""
    protocol = tables.get("protocol")
    name = protocol.get("budget") if isinstance(protocol, dict) else None
    if isinstance(name, str) and name not in BUDGETS:
        yield Finding(key("protocol", "budget"), f"There is no budget {shown(name)}.", _close(name, BUDGETS))


@rule("manifest")
def unknown_report(tables: Tables) -> Iterator[Finding]:
    """A reported entry names one of the published tables that the project keeps with its sources."""
    name = tables.get("reported")
    if isinstance(name, str) and name not in TABLES:
        yield Finding(key("", "reported"), f"There is no table {shown(name)}.", _close(name, TABLES))


def _unfit(value: object, inside: bool = False) -> str:
    """Why a value cannot be a hyperparameter; empty where it can."""
    if isinstance(value, list) and not inside:
        if len(value) > SHORT:
            return f"has {len(value)} elements; {SHORT} are allowed"
        return next(filter(None, (_unfit(one, True) for one in value)), "")
    if isinstance(value, str):
        return f"has {len(value)} characters; {LONG} are allowed" if len(value) > LONG else ""
    if isinstance(value, float):
        return "" if math.isfinite(value) else "is not finite"
    if isinstance(value, int):
        return "" if abs(value) < 2**63 else "is too large"
    return "is of another kind"


@rule("manifest")
def bad_hyperparameter(tables: Tables) -> Iterator[Finding]:
    """A hyperparameter is a text, a finite number, true or false, or a list of them."""
    given = tables.get(FREE)
    for name, value in given.items() if isinstance(given, dict) else ():
        if unfit := _unfit(value):
            yield Finding(
                key(FREE, name),
                f"{shown(value)} {unfit}.",
                "Give a text, a finite number, true or false, or a list of them.",
            )
