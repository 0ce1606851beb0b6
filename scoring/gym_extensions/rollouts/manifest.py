"""submission.toml as a value: who, what, how; read strictly, so that a misspelt key is told, not ignored."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import Any

from gym_extensions.catalog.budgets import BUDGETS, Budget

Scalar = str | int | float | bool

TEXT = "a text"
COUNT = "a whole number"
FLAG = "true or false"
URL = "a web address, or an empty text"
NAMES = "a list of texts"
DIGEST = "a sha256 in 64 hexadecimal digits, or an empty text"
SHORT, LONG = 100, 4000
DEEPEST = 8
"""So many tables and lists may stand in one another."""


@dataclass(frozen=True)
class Field:
    """One key of submission.toml: its kind of value, which values are allowed (all, if none is named)."""

    kind: str
    choices: tuple[Scalar, ...] = ()
    required: bool = True
    longest: int = SHORT


SECTIONS: dict[str, dict[str, Field]] = {
    "": {
        "format": Field(COUNT, choices=(1,)),
        "title": Field(TEXT),
        "authors": Field(NAMES),
        "description": Field(TEXT, longest=LONG),
        "reported": Field(TEXT, required=False),
    },
    "code": {"url": Field(URL, longest=500), "commit": Field(TEXT)},
    "protocol": {
        "budget": Field(TEXT, choices=tuple(BUDGETS)),
        "algorithm": Field(TEXT),
        "evaluation": Field(TEXT, choices=("sampled", "deterministic")),
    },
    "knows": {name: Field(FLAG) for name in ("task_in_training", "task_in_evaluation", "boundaries")},
    "memory": {name: Field(COUNT) for name in ("stored_steps", "parameters_first", "parameters_last")},
    "versions": {
        name: Field(TEXT) for name in ("gym_extensions", "gymnasium", "mujoco", "numpy", "python", "platform")
    },
    "archive": {"url": Field(URL, longest=500), "sha256": Field(DIGEST)},
    "hyperparameters": {},
}
"""Every key of submission.toml, by section; the keys of ``hyperparameters`` are free."""

FREE = "hyperparameters"
OPTIONAL_SECTIONS = ("archive", FREE)
REPORTED_LACKS = ("memory", "versions")
"""Sections that a published table, which has no logs, may leave out."""


@dataclass(frozen=True)
class Manifest:
    """What a submission says of itself. ``reported`` names a published table that stands in for logs."""

    title: str
    authors: tuple[str, ...]
    description: str
    code: dict[str, str]
    budget: str
    algorithm: str
    evaluation: str
    hyperparameters: dict[str, Any]
    knows: dict[str, bool]
    memory: dict[str, int]
    versions: dict[str, str]
    archive: dict[str, str]
    reported: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The manifest as it stands in the scorecard's JSON."""
        return {
            "authors": list(self.authors),
            "description": self.description,
            "code": self.code,
            "protocol": {"budget": self.budget, "algorithm": self.algorithm, "evaluation": self.evaluation},
            "hyperparameters": self.hyperparameters,
            "knows": self.knows,
            "memory": self.memory,
            "versions": self.versions,
            "archive": self.archive,
        }


def parse(data: bytes) -> dict[str, Any]:
    """The tables of a TOML file.

    Raises ValueError (tomllib's or Unicode's) where it is malformed, RecursionError where it is too deep.
    """
    tables = tomllib.loads(data.decode("utf-8"))
    level: list[Any] = [tables]
    for _ in range(DEEPEST):
        inner = [value for one in level for value in (one.values() if isinstance(one, dict) else one)]
        level = [value for value in inner if isinstance(value, (dict, list))]
    if level:
        raise RecursionError
    return tables


def budget_said(tables: dict[str, Any]) -> Budget | None:
    """The budget that tables name, whatever else is wrong with them; None where they name none."""
    protocol = tables.get("protocol")
    name = protocol.get("budget") if isinstance(protocol, dict) else None
    return BUDGETS.get(name) if isinstance(name, str) else None


def learns_said(tables: dict[str, Any]) -> bool | None:
    """Whether the agent has parameters to train, by tables that may be wrong elsewhere; None if not said."""
    memory = tables.get("memory")
    count = memory.get("parameters_last") if isinstance(memory, dict) else None
    return count > 0 if isinstance(count, int) else None


def manifest(tables: dict[str, Any]) -> Manifest:
    """The manifest of tables in which no rule found a problem."""
    protocol = tables["protocol"]
    return Manifest(
        title=tables["title"],
        authors=tuple(tables["authors"]),
        description=tables["description"],
        code=dict(tables["code"]),
        budget=protocol["budget"],
        algorithm=protocol["algorithm"],
        evaluation=protocol["evaluation"],
        hyperparameters=dict(tables.get(FREE, {})),
        knows=dict(tables["knows"]),
        memory=dict(tables.get("memory", {})),
        versions=dict(tables.get("versions", {})),
        archive=dict(tables.get("archive", {})),
        reported=tables.get("reported", ""),
    )
