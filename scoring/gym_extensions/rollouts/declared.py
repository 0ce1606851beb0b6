"""Single values of submission.toml that other rules need, even if the file has problems elsewhere."""

from __future__ import annotations

from typing import Any

from gym_extensions.catalog.budgets import BUDGETS, Budget


def _declared(tables: dict[str, Any], section: str, key: str) -> object:
    """The value of a key in tables that may be wrong elsewhere, or None."""
    table = tables.get(section)
    return table.get(key) if isinstance(table, dict) else None


def budget_of(tables: dict[str, Any]) -> Budget | None:
    """The budget that the tables name, even if they have other problems. None if they name none."""
    name = _declared(tables, "protocol", "budget")
    return BUDGETS.get(name) if isinstance(name, str) else None


def trainable_of(tables: dict[str, Any]) -> bool | None:
    """Whether the agent has parameters to train, even if the tables have other problems. None if unknown."""
    count = _declared(tables, "memory", "parameters_last")
    return count > 0 if isinstance(count, int) else None


def evaluation_of(tables: dict[str, Any]) -> str | None:
    """How actions are selected in evaluation, even if the tables have other problems. None if unknown."""
    evaluation = _declared(tables, "protocol", "evaluation")
    return evaluation if isinstance(evaluation, str) else None


def task_in_evaluation_of(tables: dict[str, Any]) -> bool | None:
    """Whether the agent observes the task in evaluation, even if the tables have other problems."""
    observes = _declared(tables, "observes", "task_in_evaluation")
    return observes if isinstance(observes, bool) else None
