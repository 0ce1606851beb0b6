"""Single values of submission.toml that is wrong elsewhere."""

from __future__ import annotations

import pytest

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.rollouts.declared import budget_of, trainable_of


def test_declarations_are_read_from_tables_with_other_problems() -> None:
    assert budget_of({"protocol": {"budget": "100k"}}) is BUDGETS["100k"]
    assert trainable_of({"memory": {"parameters_last": 0}}) is False
    assert trainable_of({"memory": {"parameters_last": 7}}) is True


@pytest.mark.parametrize("table", [None, 5, [], {}, {"budget": [], "parameters_last": "7"}])
def test_what_is_not_declared_is_unknown(table: object) -> None:
    assert budget_of({"protocol": table}) is None
    assert trainable_of({"memory": table}) is None
