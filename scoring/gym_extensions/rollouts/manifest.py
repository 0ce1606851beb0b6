"""Dataclasses of submission.toml, which states who submits, what was run, and how.

Every key is declared here, once.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Annotated, Any, Literal, get_args, get_type_hints

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.rollouts.manifest_values import (
    COUNT,
    DIGEST,
    FLAG,
    LONG,
    NAMES,
    TEXT,
    URL,
    Hyperparameter,
    Key,
)

FORMAT = 1
HYPERPARAMETERS = "hyperparameters"
PACKAGES = "packages"
FREE_SECTIONS = (HYPERPARAMETERS, PACKAGES)
"""The sections with free keys."""

Evaluation = Literal["sampled", "deterministic"]
EVALUATIONS: tuple[str, ...] = get_args(Evaluation)
"""How an agent selects actions during evaluation."""

Steps = Literal["recorded", "claimed"]
RECORDED, CLAIMED = get_args(Steps)
"""Whether the training loop counted the training steps, or the submitter states them."""

Text = Annotated[str, Key(TEXT)]
Url = Annotated[str, Key(URL, max_length=500)]
Count = Annotated[int, Key(COUNT)]
Flag = Annotated[bool, Key(FLAG)]


@dataclass(frozen=True, slots=True)
class Code:
    """Where the agent's code is. Either may be empty."""

    url: Url
    commit: Text


@dataclass(frozen=True, slots=True)
class Protocol:
    """The training budget, the algorithm, how it selects actions in evaluation, who counted the steps."""

    budget: Annotated[str, Key(TEXT, choices=tuple(BUDGETS))]
    algorithm: Text
    evaluation: Annotated[Evaluation, Key(TEXT, choices=EVALUATIONS)]
    steps: Annotated[Steps, Key(TEXT, choices=(RECORDED, CLAIMED), required=False)] = "recorded"


@dataclass(frozen=True, slots=True)
class Observes:
    """What the agent observes besides the task's observations: the task's identity, and task boundaries."""

    task_in_training: Flag
    task_in_evaluation: Flag
    boundaries: Flag


@dataclass(frozen=True, slots=True)
class Tuning:
    """Training steps spent on choosing the settings, over all trials, and the tasks of these trials."""

    steps: Count
    tasks: Annotated[tuple[str, ...], Key(NAMES)]


@dataclass(frozen=True, slots=True)
class Memory:
    """Most transitions stored at once; parameters at the start and end of training, the largest per group."""

    stored_steps: Count
    parameters_first: Count
    parameters_last: Count


@dataclass(frozen=True, slots=True)
class Versions:
    """Versions of the packages, the platform and the BLAS kernels that the runs used."""

    gym_extensions: Text
    gymnasium: Text
    mujoco: Text
    numpy: Text
    python: Text
    platform: Text
    blas: Annotated[str, Key(TEXT, required=False)] = ""


@dataclass(frozen=True, slots=True)
class Archive:
    """The complete set of traces."""

    url: Url
    sha256: Annotated[str, Key(DIGEST)]


@dataclass(frozen=True, slots=True)
class Traces:
    """The Merkle root over the digests of all traces, in the order of the logs."""

    root: Annotated[str, Key(DIGEST)]


@dataclass(frozen=True)
class Manifest:
    """A submission's manifest. ``reported`` names a published table that replaces logs.

    ``packages`` has the versions of the packages that the agent uses besides those of ``versions``.

    ``tuning``, ``memory`` and ``versions`` are None only if ``reported`` is set.
    """

    format: Annotated[Literal[1], Key(COUNT, choices=(FORMAT,))]
    title: Text
    authors: Annotated[tuple[str, ...], Key(NAMES)]
    description: Annotated[str, Key(TEXT, max_length=LONG)]
    code: Code
    protocol: Protocol
    observes: Observes
    tuning: Tuning | None = None
    memory: Memory | None = None
    versions: Versions | None = None
    archive: Archive | None = None
    traces: Traces | None = None
    hyperparameters: dict[str, Hyperparameter] = field(default_factory=dict)
    packages: dict[str, str] = field(default_factory=dict)
    reported: Annotated[str, Key(TEXT, required=False)] = ""


SECTION_TYPES = {
    "code": Code,
    "protocol": Protocol,
    "observes": Observes,
    "tuning": Tuning,
    "memory": Memory,
    "versions": Versions,
    "archive": Archive,
    "traces": Traces,
}


def _keys(section: type) -> dict[str, Key]:
    hints = get_type_hints(section, include_extras=True)
    annotations = {item.name: getattr(hints[item.name], "__metadata__", ()) for item in fields(section)}
    return {name: metadata[0] for name, metadata in annotations.items() if metadata}


SECTIONS: dict[str, dict[str, Key]] = {
    "": _keys(Manifest),
    **{name: _keys(section) for name, section in SECTION_TYPES.items()},
    **{name: {} for name in FREE_SECTIONS},
}
"""The keys of submission.toml by section; ``""`` is the top level, and ``FREE_SECTIONS`` have free keys."""
OPTIONAL_SECTIONS = ("archive", "traces", *FREE_SECTIONS)
OPTIONAL_IF_REPORTED = ("tuning", "memory", "versions")
"""Sections that a published table, which has no logs, may leave out."""


def manifest_of(tables: dict[str, Any]) -> Manifest:
    """The manifest in tables without problems."""
    sections = {
        name: section(
            **{key: tuple(value) if isinstance(value, list) else value for key, value in tables[name].items()}
        )
        for name, section in SECTION_TYPES.items()
        if name in tables
    }
    return Manifest(**{**tables, **sections, "authors": tuple(tables["authors"])})
