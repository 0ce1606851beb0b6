"""Published tables that stand on the board without logs: the level of trust *reported*."""

from __future__ import annotations

TABLES = {"henderson2017": "henderson2017.csv"}
"""The files of published tables, in ``references/``, by the name that submission.toml gives."""
