"""What a submission says of itself, as its scorecard shows it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated

from gym_extensions.rollouts.manifest import Archive, Code, Manifest, Memory, Observes, Protocol, Tuning
from gym_extensions.scoring.documents import about

Scalar = str | int | float | bool
Hyperparameter = Scalar | tuple[Scalar, ...]


@dataclass(frozen=True, slots=True)
class ManifestSummary:
    """The sections of submission.toml, with the keys that docs/rollout-log.md documents."""

    authors: Annotated[tuple[str, ...], about("names")]
    description: Annotated[str, about("free text")]
    code: Code
    protocol: Protocol
    hyperparameters: Annotated[dict[str, Hyperparameter], about("free keys")]
    observes: Observes
    tuning: Annotated[Tuning | None, about("null in a reported entry")]
    memory: Annotated[Memory | None, about("null in a reported entry")]
    versions: Annotated[dict[str, str], about("versions of all packages; empty in a reported entry")]
    archive: Annotated[Archive | None, about("null without the section")]


def summarize_manifest(manifest: Manifest) -> ManifestSummary:
    """The manifest of a submission, in the form of its scorecard."""
    versions = asdict(manifest.versions) if manifest.versions else {}
    return ManifestSummary(
        authors=manifest.authors,
        description=manifest.description,
        code=manifest.code,
        protocol=manifest.protocol,
        hyperparameters={
            name: tuple(value) if isinstance(value, list) else value
            for name, value in manifest.hyperparameters.items()
        },
        observes=manifest.observes,
        tuning=manifest.tuning,
        memory=manifest.memory,
        versions={name: text for name, text in versions.items() if text} | manifest.packages,
        archive=manifest.archive,
    )
