"""The published groups, their tasks, and the evaluation protocol."""

import hashlib
from collections import Counter
from itertools import pairwise

import pytest

from gym_extensions.catalog.groups import CORE, CORES, GROUPS, PAPER_GROUPS, group, groups_named
from gym_extensions.catalog.protocol import BUDGETS, balanced_square, evaluation_seed, task_order
from gym_extensions.catalog.tasks import FAMILIES, TASKS

MUJOCO_GROUPS = [name for name, row in GROUPS.items() if row.tasks[0].base != "Navigation"]
RUNNING = ("hopper", "walker2d", "halfcheetah", "humanoid")
PAPER = [
    *(f"{body}-{kind}" for kind in ("gravity", "body", "wall") for body in RUNNING),
    *("humanoid-standup-run", "humanoid-standup-run-wall", "striker", "pusher"),
]
EXTRAS = [
    *(f"{body}-{kind}" for kind in ("motor-noise", "noisy-wall") for body in RUNNING),
    *("pusher-tracking", "striker-tracking"),
]


def test_the_paper_has_75_mujoco_tasks_in_16_groups() -> None:
    assert [row.name for row in PAPER_GROUPS][:16] == PAPER
    assert len({row.id for name in PAPER for row in GROUPS[name].tasks}) == 75
    assert [name for name in MUJOCO_GROUPS if name not in PAPER] == EXTRAS


def test_there_are_150_navigation_tasks_in_five_groups_of_thirty_map_by_map() -> None:
    assert len([row for row in TASKS.values() if row.base == "Navigation"]) == 150
    for family, pattern in FAMILIES.items():
        names = [pattern.format(map=number, goal=goal) for number in range(10) for goal in range(3)]
        assert [row.name for row in group(f"nav-{family}").tasks] == names


def test_the_core_is_seven_groups_that_cost_8_7_million_steps() -> None:
    members = groups_named("core")
    assert members == groups_named("core-v1")
    assert tuple(member.id for member in members) == CORES[CORE]
    assert len(members) == 7
    assert sum(BUDGETS["300k"].steps_for(member.name) * len(member.tasks) for member in members) == 8_700_000
    assert groups_named("pusher") == (group("pusher"),)


def test_an_evaluation_seed_is_the_start_of_a_sha256_digest() -> None:
    digest = hashlib.sha256(b"hopper-gravity-v0/gym_extensions/Hopper-v0/7").digest()
    expected = int.from_bytes(digest[:4], "little") % 2**31
    assert evaluation_seed("hopper-gravity-v0", "gym_extensions/Hopper-v0", 7) == expected


def test_a_budget_counts_training_steps_per_task() -> None:
    assert BUDGETS["1M"].steps_for("hopper-gravity") == 1_000_000
    assert BUDGETS["paper"].steps_for("hopper-body") * 2 == BUDGETS["paper"].steps_for("hopper-gravity")
    assert BUDGETS["paper"].steps_for("my-body") == BUDGETS["paper"].steps_for("hopper-gravity")
    assert BUDGETS["100k"].steps_for("hopper-body") == BUDGETS["100k"].steps_for("hopper-gravity")


@pytest.mark.parametrize("count", range(1, 15))
def test_a_square_is_balanced_in_positions_and_in_what_follows_what(count: int) -> None:
    rows = balanced_square(count)
    assert all(sorted(row) == list(range(count)) for row in rows)
    assert len(rows) == (2 * count if count % 2 and count > 1 else count)
    places = Counter(place for row in rows for place in enumerate(row))
    follows = Counter(pair for row in rows for pair in pairwise(row))
    assert (len(places), len(set(places.values()))) == (count * count, 1)
    assert (len(follows), len(set(follows.values()))) == (count * (count - 1), min(1, count - 1))


def test_the_square_of_five_tasks_is_fixed() -> None:
    first = [(0, 1, 4, 2, 3), (1, 2, 0, 3, 4), (2, 3, 1, 4, 0), (3, 4, 2, 0, 1), (4, 0, 3, 1, 2)]
    assert balanced_square(5) == (*first, *(row[::-1] for row in first))


def test_the_order_of_a_run_follows_from_protocol_and_number() -> None:
    assert task_order("sequential", 3, 4) == task_order("single", 3, 4) == (0, 1, 2, 3)
    assert task_order("descending", 3, 4) == (3, 2, 1, 0)
    assert [task_order("balanced", run, 2) for run in range(3)] == [(0, 1), (1, 0), (0, 1)]
