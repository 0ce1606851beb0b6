"""Results that were published as tables, without logs."""

from __future__ import annotations

from dataclasses import dataclass

TABLES = {"henderson2017": "henderson2017.csv"}
"""The files of published tables, in ``scoring/published/data/``, by the name that submission.toml gives."""


@dataclass(frozen=True)
class Report:
    """The fixed facts of the entry that shows a published table."""

    entry: str
    budget: str
    algorithm: str


REPORTS = {"henderson2017": Report("henderson2017-trpo", "paper", "trpo")}
"""The entry of every published table, by the name in submission.toml."""
