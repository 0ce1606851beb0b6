"""Rules about submission.toml and README.md: their keys, values and characters."""

import math
import unicodedata
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, Literal, get_args, get_origin

import msgspec

from gym_extensions.catalog.protocol import REPORTS
from gym_extensions.errors import did_you_mean
from gym_extensions.submissions import characters
from gym_extensions.submissions.layout import MANIFEST, README, WRITTEN, Folder
from gym_extensions.submissions.manifest import LONG, SECTIONS, SHORT, Manifest, Observes
from gym_extensions.submissions.problem import MAX_QUOTE, Finding, quote, rule

MULTILINE = ("description", "hyperparameters")
"""Keys whose strings may have line breaks and tabs."""
Tables = dict[str, Any]
"""The tables of submission.toml."""


def where_of(section: str, name: str) -> str:
    """Where a key is, for the ``where`` of a finding."""
    bare = name if name.replace("-", "_").isidentifier() and len(name) <= MAX_QUOTE else quote(name)
    return f"{MANIFEST}, {f'[{section}] ' if section else ''}{bare}"


def _sections(tables: Tables) -> Iterator[tuple[str, type[msgspec.Struct], Tables]]:
    """Name, type and content of the top level, whose name is empty, and of each section with fixed keys."""
    yield "", Manifest, tables
    for section, kind in SECTIONS.items():
        if isinstance(tables.get(section), dict):
            yield section, kind, tables[section]


@rule("manifest")
def unknown_key(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """Every section and key of submission.toml is one that docs/rollout-log.md lists; only [hyperparameters]
    has free keys."""
    for section, kind, table in _sections(tables):
        for name in table:
            if name not in kind.__struct_fields__:
                hint = did_you_mean(name[:MAX_QUOTE], kind.__struct_fields__)
                yield Finding(where_of(section, name), f"Unknown key {quote(name)}.", hint)


@rule("manifest")
def missing_key(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """submission.toml has every required section and key."""
    for section, kind, table in _sections(tables):
        for key in msgspec.structs.fields(kind):
            is_required = key.required or kind is Observes or (kind is Manifest and key.name == "format")
            if is_required and key.name not in table:
                yield Finding(where_of(section, key.name), "The key is missing.", f"Add {key.name}.")
    if "tuning" not in tables and "reported" not in tables:
        yield Finding(where_of("", "tuning"), "The section is missing.", "Add [tuning].")


@rule("manifest")
def bad_value(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """Every value of submission.toml is of its key's kind, within its length and among its choices; every
    section is a table."""
    for section, kind, table in _sections(tables):
        for key in msgspec.structs.fields(kind):
            if key.name not in table:
                continue
            where, value = where_of(section, key.name), table[key.name]
            if section or key.name not in (*SECTIONS, "hyperparameters"):
                yield from _value_findings(where, key.type, value)
            elif not isinstance(value, dict):
                hint = f"Write [{key.name}] and its keys."
                yield Finding(where, f"{quote(value)} is not a section.", hint)
    settings = tables.get("hyperparameters")
    for name, value in settings.items() if isinstance(settings, dict) else ():
        if error := hyperparameter_error(value):
            hint = "Write a string, a finite number, true or false, or a list of them."
            yield Finding(where_of("hyperparameters", name), f"{quote(value)} {error}.", hint)


def _value_findings(where: str, kind: Any, value: object) -> Iterator[Finding]:
    """What is wrong with the value of a key, which is a choice or has a description."""
    with suppress(msgspec.ValidationError):
        msgspec.convert(value, kind)
        return
    if get_origin(kind) is Literal:
        choices = [str(choice) for choice in get_args(kind)]
        closest = did_you_mean(value[:MAX_QUOTE], choices) if isinstance(value, str) else ""
        yield Finding(where, f"The value is {quote(value)}.", closest or f"Write {' or '.join(choices)}.")
        return
    wanted = kind.__metadata__[0].description
    length = f" (it has {len(value)})" if isinstance(value, str) and len(value) > SHORT else ""
    yield Finding(where, f"{quote(value)} is not {wanted}{length}.", f"Write {wanted}.")


def hyperparameter_error(value: object, *, is_element: bool = False) -> str:
    """What is wrong with a hyperparameter or an element of one, as the end of a sentence, or empty."""
    if isinstance(value, list | tuple) and not is_element:
        if len(value) > SHORT:
            return f"has {len(value)} elements; the limit is {SHORT}"
        errors = (hyperparameter_error(element, is_element=True) for element in value)
        return next((error for error in errors if error), "")
    if isinstance(value, str):
        return f"has {len(value)} characters; the limit is {LONG}" if len(value) > LONG else ""
    if isinstance(value, float):
        return "" if math.isfinite(value) else "is not finite"
    if isinstance(value, int):
        return "" if abs(value) < 2**63 else "is too large"
    container = "contains an element" if is_element else "is"
    return f"{container} of type {type(value).__name__}"


@rule("manifest")
def unknown_report(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """The key ``reported`` names a published table that the project includes; each table has one submission,
    with a fixed folder name, budget and algorithm."""
    name, protocol = tables.get("reported"), tables.get("protocol")
    if not isinstance(name, str):
        return
    report = REPORTS.get(name)
    if report is None:
        hint = did_you_mean(name[:MAX_QUOTE], REPORTS)
        yield Finding(where_of("", "reported"), f"Unknown table {quote(name)}.", hint)
        return
    if folder.name != report.submission:
        message = f"The table {name!r} belongs to the folder {report.submission!r}."
        hint = "Remove the key 'reported', and submit the logs of your own runs."
        yield Finding(folder.name, message, hint)
    for key in ("budget", "algorithm"):
        value = protocol.get(key) if isinstance(protocol, dict) else None
        expected = getattr(report, key)
        if isinstance(value, str) and value != expected:
            message = f"The value is {quote(value)}; expected {expected!r} for the table {name!r}."
            yield Finding(where_of("protocol", key), message, f"Write {expected!r}.")


@rule("manifest")
def no_groups(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """A submission contains at least one group folder or agent/, unless it is a reported submission, which
    has none."""
    items = (item for item in folder.items if item.kind == "folder" and "/" not in item.path)
    folders = [item.path for item in items if item.path not in WRITTEN]
    if "reported" in tables:
        for path in folders:
            hint = "Remove the key 'reported' from submission.toml, or remove the folder."
            yield Finding(path, "A reported submission cannot contain a group folder.", hint)
    elif not folders:
        hint = "Add runs or code, as described in docs/submit.md."
        yield Finding(folder.name, "The submission contains no group folder and no agent/.", hint)


def strings(value: object, where: str, multiline: bool = False) -> Iterator[tuple[str, str, bool]]:
    """Every string, keys included, with its location and whether it may have line breaks."""
    if isinstance(value, str):
        yield where, value, multiline
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield where, name, False
            yield from strings(inner, f"{where}, {quote(name)[1:-1]}", multiline or name in MULTILINE)
    elif isinstance(value, list):
        for inner in value:
            yield from strings(inner, where, multiline)


@rule("manifest")
def empty_title(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """The title contains at least one visible character."""
    title = tables.get("title")
    if isinstance(title, str) and not characters.is_visible(title):
        message = f"The title {quote(title)} has no visible character."
        yield Finding(where_of("", "title"), message, "Name the submission.")


@rule("manifest")
def control_character(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """Strings contain no control, invisible or bidirectional-override characters, start with no combining
    mark and have at most five in a row. (The description and hyperparameters may contain line breaks and
    tabs.)"""
    for where, value, multiline in strings(tables, MANIFEST):
        text = value.replace("\n", "").replace("\t", "") if multiline else value
        if characters.first_invisible(text):
            yield Finding(where, f"{quote(value)} contains a control or invisible character.", "Remove it.")
        elif characters.has_stacked_marks(value):
            message = f"{quote(value)} has combining marks that cover other texts."
            yield Finding(where, message, "Remove them.")


@rule("manifest")
def script(folder: Folder, tables: Tables) -> Iterator[Finding]:
    """Each word of the title, of an author and of the algorithm has letters of one script that is widely
    used, such as Latin, Cyrillic or Thai; Chinese, Japanese and Korean letters may stand beside them. (A
    Greek symbol is a word of its own: β-VAE.)"""
    shown = {name: tables.get(name) for name in ("title", "authors")}
    protocol = tables.get("protocol")
    shown |= {"algorithm": protocol.get("algorithm") if isinstance(protocol, dict) else None}
    for where, value, _ in strings(shown, MANIFEST):
        text = unicodedata.normalize("NFKC", value)
        for word in "".join(char if char.isalpha() else " " for char in text).split():
            scripts = characters.scripts_of(word)
            if not scripts.issubset(characters.SCRIPTS):
                known = ", ".join(characters.SCRIPTS).title()
                hint = f"Write it in letters of {known}, Chinese, Japanese or Korean."
                yield Finding(where, f"{quote(word)} has letters of another script.", hint)
            elif len(scripts) > 1:
                message = f"{quote(word)} has letters of several scripts, which may look alike."
                yield Finding(where, message, "Write each word in letters of one script.")


@rule("readme")
def readme_character(data: bytes) -> Iterator[Finding]:
    """README.md is UTF-8 text without control, invisible or bidirectional-override characters except line
    breaks and tabs, and without lines with stacked combining marks."""
    try:
        lines = data.decode("utf-8").replace("\r\n", "\n").split("\n")
    except UnicodeDecodeError as error:
        number = data.count(b"\n", 0, error.start) + 1
        message = f"Byte {data[error.start]:#04x} is not UTF-8."
        yield Finding(f"{README}, line {number}", message, "Save the file as UTF-8.")
        return
    for number, line in enumerate(lines, 1):
        where = f"{README}, line {number}"
        if char := characters.first_invisible(line.replace("\t", "")):
            message = f"The line contains the control or invisible character U+{ord(char):04X}."
            yield Finding(where, message, "Remove it.")
        elif characters.has_stacked_marks(line):
            yield Finding(where, "The line has combining marks that cover other texts.", "Remove them.")
