"""Published tables of results without logs: their files and their entries."""

from __future__ import annotations

from dataclasses import dataclass

TABLES = {"henderson2017": "henderson2017.csv"}
"""The files of published tables, in ``scoring/published/data/``, by the name that submission.toml gives."""


@dataclass(frozen=True)
class Report:
    """What is fixed of the one entry that shows a published table."""

    entry: str
    budget: str
    algorithm: str


REPORTS = {"henderson2017": Report("henderson2017-trpo", "paper", "trpo")}
"""The entry of each published table, by the name that submission.toml gives."""
