"""The evaluation protocol: prescribed seeds, stages, rows per run; and the training budgets."""

from __future__ import annotations

import hashlib

import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import BUDGETS, budget, evaluation_seed, per_run, stages
from gym_extensions.errors import BenchError


def test_an_evaluation_seed_is_the_start_of_a_sha256_digest() -> None:
    digest = hashlib.sha256(b"hopper-gravity-v0/gym_extensions/Hopper-v0/7").digest()
    expected = int.from_bytes(digest[:4], "little") % 2**31
    assert evaluation_seed("hopper-gravity-v0", "gym_extensions/Hopper-v0", 7) == expected


def test_evaluation_seeds_of_a_group_differ() -> None:
    row = group("hopper-gravity")
    seeds = {evaluation_seed(row.id, task_id, episode) for task_id in row.task_ids for episode in range(20)}
    assert len(seeds) == 100


@pytest.mark.parametrize(
    ("protocol", "expected", "rows"), [("sequential", (0, 1, 2, 3, 4, 5), 600), ("single", (1,), 100)]
)
def test_a_protocol_has_its_stages_and_rows(protocol: str, expected: tuple[int, ...], rows: int) -> None:
    assert stages(protocol, 5) == expected
    assert per_run(protocol, group("hopper-gravity")) == rows


def test_a_budget_counts_training_steps_per_task() -> None:
    assert BUDGETS["1M"].steps_for("hopper-gravity") == 1_000_000
    assert BUDGETS["paper"].steps_for("hopper-body") * 2 == BUDGETS["paper"].steps_for("hopper-gravity")
    assert BUDGETS["100k"].steps_for("hopper-body") == BUDGETS["100k"].steps_for("hopper-gravity")


def test_an_unknown_budget_raises_an_error_with_the_closest_name() -> None:
    with pytest.raises(BenchError) as caught:
        budget("papr")
    assert str(caught.value) == "There is no budget 'papr'. Did you mean 'paper'?"
