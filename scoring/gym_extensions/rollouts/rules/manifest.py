"""Rules about submission.toml."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.published import TABLES
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.manifest import (
    FREE_SECTIONS,
    HYPERPARAMETERS,
    OPTIONAL_IF_REPORTED,
    OPTIONAL_SECTIONS,
    PACKAGES,
    SECTIONS,
)
from gym_extensions.rollouts.manifest_values import (
    HYPERPARAMETER,
    TEXT,
    Key,
    hyperparameter_error,
    value_error,
)
from gym_extensions.rollouts.problem import MAX_QUOTE, Finding, quote
from gym_extensions.rollouts.reading.toml_text import MAX_NESTING, parse
from gym_extensions.rollouts.rules.rule import rule

Tables = dict[str, Any]
BARE = re.compile(r"[A-Za-z0-9_-]{1,80}")


def bare(name: str) -> str:
    """A key as in TOML, without quotes if possible."""
    return name if BARE.fullmatch(name) else quote(name)


def key_path(section: str, name: str) -> str:
    """Where a key is, for the ``where`` of a finding."""
    return f"{MANIFEST}, {f'[{section}] ' if section else ''}{bare(name)}"


def _closest(name: str, choices: Iterable[str]) -> str:
    return did_you_mean(name[:MAX_QUOTE], choices)


def _table(tables: Tables, section: str) -> object:
    """The table of a section. ``""`` is the top level."""
    return tables.get(section, {}) if section else tables


@rule("manifest bytes")
def malformed_toml(data: bytes) -> Iterator[Finding]:
    """submission.toml is TOML in UTF-8, with at most 8 levels of nested tables and lists and 8 parts of a
    dotted key."""
    try:
        parse(data)
    except ValueError as error:
        hint = "Correct the syntax; the format is described at https://toml.io."
        yield Finding(MANIFEST, f"The file is not valid TOML: {str(error)[:200]}.", hint)
    except RecursionError:
        hint = f"Use at most {MAX_NESTING} levels."
        yield Finding(MANIFEST, "Tables, lists or keys are nested too deeply.", hint)


@rule("manifest")
def unknown_key(tables: Tables) -> Iterator[Finding]:
    """Every section and key of submission.toml is one that docs/rollout-log.md lists; only [hyperparameters]
    and [packages] have free keys."""
    for name in tables:
        if name not in SECTIONS and name not in SECTIONS[""]:
            hint = _closest(name, [*filter(None, SECTIONS), *SECTIONS[""]]) or "Remove it."
            yield Finding(MANIFEST, f"Unknown key {quote(name)}.", hint)
    for section, keys in SECTIONS.items():
        table = tables.get(section) if section and section not in FREE_SECTIONS else None
        for name in table if isinstance(table, dict) else ():
            if name not in keys:
                yield Finding(key_path(section, name), f"Unknown key {quote(name)}.", _closest(name, keys))


@rule("manifest")
def missing_key(tables: Tables) -> Iterator[Finding]:
    """submission.toml has every required section and key."""
    optional = (*OPTIONAL_SECTIONS, *(OPTIONAL_IF_REPORTED if "reported" in tables else ()))
    for section, keys in SECTIONS.items():
        if section in optional and section not in tables:
            continue
        table = _table(tables, section)
        for name, key in keys.items():
            if key.required and isinstance(table, dict) and name not in table:
                hint = f"Add the key {name}: {key.kind}."
                yield Finding(key_path(section, name), "The key is missing.", hint)


@rule("manifest")
def bad_value(tables: Tables) -> Iterator[Finding]:
    """Every value of submission.toml is of its key's kind, within its length and among its choices; every
    section is a table."""
    for section, keys in SECTIONS.items():
        table = _table(tables, section)
        if not isinstance(table, dict):
            where, hint = f"{MANIFEST}, {section}", f"Write [{section}] and its keys."
            yield Finding(where, f"{quote(table)} is not a section.", hint)
            continue
        for name, key in keys.items():
            if name not in table:
                continue
            where, value = key_path(section, name), table[name]
            if error := value_error(key, value):
                yield Finding(where, error, f"Write {key.wanted}.")
            elif key.choices and value not in key.choices:
                hint = did_you_mean(str(value), [str(choice) for choice in key.choices])
                yield Finding(where, f"The value is {quote(value)}.", hint)


@rule("manifest")
def foreign_version(tables: Tables) -> Iterator[Finding]:
    """[versions] gymnasium and mujoco are the versions of the published tasks."""
    table = tables.get("versions")
    stated: Tables = table if isinstance(table, dict) else {}
    for name, expected in fingerprints.table()["engine"].items():
        version = stated.get(name)
        if isinstance(version, str) and version != expected:
            message = f"The version is {quote(version)}; the published tasks have {expected!r}."
            hint = f"Record the episodes with {name} {expected}."
            yield Finding(key_path("versions", name), message, hint)


@rule("manifest")
def unknown_report(tables: Tables) -> Iterator[Finding]:
    """The key ``reported`` names a published table that the project includes."""
    name = tables.get("reported")
    if isinstance(name, str) and name not in TABLES:
        yield Finding(key_path("", "reported"), f"Unknown table {quote(name)}.", _closest(name, TABLES))


@rule("manifest")
def bad_package(tables: Tables) -> Iterator[Finding]:
    """The version of a package in [packages] is a string, and no package of [versions] is repeated there."""
    table = tables.get(PACKAGES)
    for name, value in table.items() if isinstance(table, dict) else ():
        if error := value_error(Key(TEXT), value):
            yield Finding(key_path(PACKAGES, name), error, f"Write {TEXT}.")
        elif name in SECTIONS["versions"]:
            yield Finding(key_path(PACKAGES, name), f"{quote(name)} is a key of [versions].", "Remove it.")


@rule("manifest")
def bad_hyperparameter(tables: Tables) -> Iterator[Finding]:
    """A hyperparameter is a string, a finite number, true or false, or a list of them."""
    table = tables.get(HYPERPARAMETERS)
    for name, value in table.items() if isinstance(table, dict) else ():
        if error := hyperparameter_error(value):
            message = f"{quote(value)} {error}."
            yield Finding(key_path(HYPERPARAMETERS, name), message, f"Write {HYPERPARAMETER}.")
