"""Tasks as plain data, as fingerprints, specs and files of custom groups hold them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations import KINDS
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.errors import BenchError, did_you_mean

KEYS = ("name", "version", "base", "max_steps", "variations")


def definition(task: Task) -> dict[str, Any]:
    """Returns the task as plain data, with the kind and the values of every variation."""
    return {
        "name": task.name,
        "version": task.version,
        "base": task.base,
        "max_steps": task.max_steps,
        "variations": [_plain(variation) for variation in task.variations],
    }


def is_definable(task: Task) -> bool:
    """Returns whether ``from_definition`` can make the task: all its variations are of this package."""
    return all(KINDS.get(type(variation).__name__) is type(variation) for variation in task.variations)


def from_definition(row: Mapping[str, Any], where: str = "task") -> Task:
    """Returns the task that ``definition`` describes.

    Raises:
        BenchError: a key, kind of variation or parameter is missing or unknown, or a value is invalid.
    """
    check_keys(row, KEYS, KEYS, where)
    variations = tuple(make_variation(each, where) for each in row["variations"])
    return Task(row["name"], row["base"], variations, row["version"], row["max_steps"])


def make_variation(row: Any, where: str) -> Variation:
    """Returns the variation of a table such as ``{"kind": "Gravity", "factor": 0.5}``.

    Raises:
        BenchError: the kind or a parameter is unknown, or a value is invalid.
    """
    if not isinstance(row, Mapping):
        hint = 'Write {kind = "Gravity", factor = 0.5}.'
        raise BenchError("malformed-group", f"The variation {row!r} is not a table.", where, hint)
    if "kind" not in row:
        raise BenchError("missing-key", "The key 'kind' is missing.", where, "Add kind.")
    kind = KINDS.get(str(row["kind"]))
    if kind is None:
        hint = did_you_mean(str(row["kind"]), KINDS)
        raise BenchError("unknown-variation", f"There is no variation {row['kind']!r}.", where, hint)
    parameters = {name: value for name, value in row.items() if name != "kind"}
    names = [field.name for field in fields(kind)]
    required = [field.name for field in fields(kind) if field.default is MISSING]
    check_keys(parameters, names, required, f"{where}, {row['kind']}")
    try:
        variation: Variation = kind(**parameters)
    except TypeError as error:
        raise BenchError("bad-variation", f"{error}.", f"{where}, {row['kind']}") from error
    return variation


def check_keys(table: Mapping[str, Any], names: Iterable[str], required: Iterable[str], where: str) -> None:
    """Raises ``BenchError`` for an unknown key, or a required key that is missing."""
    for key in table:
        if key not in names:
            raise BenchError("unknown-key", f"There is no key {key!r}.", where, did_you_mean(key, names))
    for key in required:
        if key not in table:
            raise BenchError("missing-key", f"The key {key!r} is missing.", where, f"Add {key}.")


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        values = {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
        return {"kind": type(value).__name__} | values
    return [_plain(entry) for entry in value] if isinstance(value, tuple | list) else value
