"""What a submission says of itself, as its scorecard and its board entries show it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from gym_extensions.rollouts.manifest import Manifest
from gym_extensions.scoring.documents import about

Scalar = str | int | float | bool
Hyperparameter = Scalar | tuple[Scalar, ...]


@dataclass(frozen=True, slots=True)
class Code:
    """Where the code is."""

    url: Annotated[str, about("web address, or empty")]
    commit: Annotated[str, about("commit, or empty")]


@dataclass(frozen=True, slots=True)
class Protocol:
    """How the agent was trained and evaluated."""

    budget: Annotated[str, about("name of the budget")]
    algorithm: Annotated[str, about("name of the algorithm")]
    evaluation: Annotated[str, about("`sampled` or `deterministic` actions")]


@dataclass(frozen=True, slots=True)
class Observes:
    """What the agent observes besides the environment's observations."""

    task_in_training: Annotated[bool, about("the task, in training")]
    task_in_evaluation: Annotated[bool, about("the task, in evaluation")]
    boundaries: Annotated[bool, about("when the task changes")]


@dataclass(frozen=True, slots=True)
class Memory:
    """What the agent stores."""

    stored_steps: Annotated[int, about("largest number of transitions held at once")]
    parameters_first: Annotated[int, about("parameters when training starts")]
    parameters_last: Annotated[int, about("parameters when training ends")]


@dataclass(frozen=True, slots=True)
class Archive:
    """Where the complete set of traces is."""

    url: Annotated[str, about("web address, or empty")]
    sha256: Annotated[str, about("SHA-256 of the archive, or empty")]


@dataclass(frozen=True, slots=True)
class ManifestSummary:
    """The sections of submission.toml."""

    authors: Annotated[tuple[str, ...], about("names")]
    description: Annotated[str, about("free text")]
    code: Code
    protocol: Protocol
    hyperparameters: Annotated[dict[str, Hyperparameter], about("free keys")]
    observes: Observes
    memory: Annotated[Memory | None, about("null in a reported entry")]
    versions: Annotated[dict[str, str], about("versions of the packages; empty in a reported entry")]
    archive: Annotated[Archive | None, about("null without the section")]


def summarize_manifest(manifest: Manifest) -> ManifestSummary:
    """The manifest of a submission, in the form of its scorecard."""
    return ManifestSummary(
        authors=manifest.authors,
        description=manifest.description,
        code=Code(**manifest.code),
        protocol=Protocol(manifest.budget, manifest.algorithm, manifest.evaluation),
        hyperparameters={
            name: tuple(value) if isinstance(value, list) else value
            for name, value in manifest.hyperparameters.items()
        },
        observes=Observes(**manifest.knows),
        memory=Memory(**manifest.memory) if manifest.memory else None,
        versions=manifest.versions,
        archive=Archive(**manifest.archive) if manifest.archive else None,
    )
