"""The manifest of a submission that is merged from several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gym_extensions.baselines.submission.manifest import BLAS, DEFAULTS, columns, fitting, stated, stated_blas
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MANIFEST
from gym_extensions.rollouts.manifest import PACKAGES

SAME_SECTIONS = ("protocol", "hyperparameters", "observes", "code")
"""Sections that are the same in submissions that can be merged."""
ONE_AGENT = "Merge only runs of one agent with one budget and one set of hyperparameters."

Tables = Mapping[str, Any]


def require_mergeable(manifests: Mapping[Path, Tables]) -> None:
    """Raises ``BenchError`` if a manifest has another agent, budget or setting than the first."""
    (first, expected), *others = manifests.items()
    for path, tables in others:
        for section in SAME_SECTIONS:
            old, new = (
                DEFAULTS.get(section, {}) | dict(item.get(section, {})) for item in (expected, tables)
            )
            for key in sorted(old.keys() | new.keys()):
                if old.get(key) != new.get(key):
                    values = stated(old.get(key)), stated(new.get(key))
                    difference = f"{section}.{key} is {values[0]} in {first} and {values[1]} here."
                    raise BenchError("mixed-submission", difference, str(path / MANIFEST), ONE_AGENT)


def merged_tables(manifests: Sequence[Tables]) -> dict[str, Any]:
    """The manifest of all: the first one's texts, the largest memory, and every version.

    The archive stays only if it is the same in all.
    """
    tables = dict(manifests[0])
    tables["memory"] = columns(manifests, "memory", max)
    kernels = fitting([stated_blas(item) for item in manifests])
    tables["versions"] = columns(manifests, "versions", fitting) | {BLAS: kernels}
    if any(PACKAGES in item for item in manifests):
        tables[PACKAGES] = columns(manifests, PACKAGES, fitting)
    if any(item.get("archive") != tables.get("archive") for item in manifests):
        tables.pop("archive", None)
    return tables
