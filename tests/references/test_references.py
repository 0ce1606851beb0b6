"""The frozen references: what a file may hold, the published versions, and the versions before."""

import hashlib
import json
import math
from pathlib import Path

import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.references import (
    Expert,
    Floor,
    FloorAgent,
    Reference,
    add_references,
    experts,
    load_references,
    parse_references,
    path_of,
    read_references,
    trained_alone,
)

from ..conftest import refused

VERSIONS = sorted(path.stem for path in path_of().parent.glob("*.json"))
TASK_ROWS = load_references().tasks
HOPPER, HUMANOID = "gym_extensions/Hopper-v0", "gym_extensions/Humanoid-v0"
FLOOR = {"mean": 10, "agents": {"random": {"mean": 3}, "zero": {"mean": 10}}}
EXPERT = {"mean": 30.5, "standard_error": 0.5, "episodes": 100}
TASK = {"floor": FLOOR, "expert": EXPERT}
OPEN = {"floor": {"mean": 1}, "expert": None}


def a_file(**changes: object) -> bytes:
    """The bytes of a references file."""
    return json.dumps({"format": 2, "version": "v1", "tasks": {HOPPER: TASK}} | changes).encode()


@pytest.mark.parametrize("version", VERSIONS)
def test_every_version_loads(version: str) -> None:
    found = load_references(version)
    assert found.version == version
    assert found.digest == hashlib.sha256(path_of(version).read_bytes()).hexdigest()
    assert len(found.tasks) == {"1": 235, "2": 237}[version], "a released version never changes"


def test_references_are_read_and_pinned_by_their_bytes() -> None:
    data = a_file(tasks={HOPPER: TASK, HUMANOID: OPEN})
    found = parse_references(data)
    assert found.version == "v1"
    assert found.tasks == {
        HOPPER: Reference(
            Floor(10.0, agents={"random": FloorAgent(3.0), "zero": FloorAgent(10.0)}), Expert(30.5, 0.5, 100)
        ),
        HUMANOID: Reference(Floor(1.0), None),
    }
    assert found.missing([HOPPER, "gym_extensions/Pusher-v0"]) == ["gym_extensions/Pusher-v0"]
    assert found.digest != parse_references(data + b"\n").digest


def test_of_several_runs_the_run_is_the_unit_of_the_error() -> None:
    runs = [{"run": 1000, "mean": 30}, {"run": 1001, "mean": 31}]
    data = a_file(tasks={HOPPER: {"floor": FLOOR, "expert": EXPERT | {"runs": runs}}})
    assert parse_references(data).tasks[HOPPER].expert_error == (0.5 / 20.5, 1)


def test_why_an_expert_is_provisional_is_kept() -> None:
    data = a_file(tasks={HOPPER: {"floor": FLOOR, "expert": EXPERT | {"provisional": "it sits"}}})
    expert = parse_references(data).tasks[HOPPER].expert
    assert expert is not None and expert.provisional == "it sits"


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"[1]", "object"),
        (b"{", "truncated"),
        (b"[" * 100_000, ""),
        (a_file(format=3), "3"),
        (a_file(tasks=[]), "tasks"),
        (a_file(tasks={HOPPER: {"expert": EXPERT}}), "floor"),
        (a_file(tasks={HOPPER: {"floor": FLOOR}}), "expert"),
        (a_file(tasks={HOPPER: TASK | {"expert": EXPERT | {"mean": 10}}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"expert": EXPERT | {"mean": 9}}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"expert": EXPERT | {"standard_error": -1}}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"expert": EXPERT | {"episodes": 1}}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"floor": {"mean": math.nan}}}), "JSON"),
        (a_file().replace(b"30.5", b"1e999"), ""),
    ],
)
def test_a_file_that_holds_no_references_is_an_error_that_says_where(
    data: bytes, told: str, tmp_path: Path
) -> None:
    path = tmp_path / "r.json"
    path.write_bytes(data)
    with refused("malformed-references", told, "r.json"):
        read_references(path)


def test_own_references_add_tasks_and_replace_none() -> None:
    own = parse_references(a_file(tasks={HOPPER: TASK | {"expert": EXPERT | {"mean": 99}}, HUMANOID: OPEN}))
    both = add_references(parse_references(a_file()), own)
    assert both.tasks[HOPPER].expert == Expert(30.5, 0.5, 100)
    assert both.tasks[HUMANOID].open
    assert both.version == "v1 + v1"


def test_of_every_mujoco_task_of_a_group_the_runs_on_it_alone_are_known() -> None:
    tasks = {task.id for group in GROUPS.values() for task in group.tasks if task.base != "Navigation"}
    assert set(trained_alone()) == tasks & load_references("1").tasks.keys()
    assert {len(each.runs) for each in trained_alone().values()} == {5}


def test_the_current_version_has_every_task_and_floors_of_its_definition() -> None:
    assert list(TASK_ROWS) == list(TASKS)
    first = load_references("1").tasks
    for name, row in TASK_ROWS.items():
        assert row.floor.fingerprint == published(name)
        assert row.floor.mean == max(agent.mean for agent in row.floor.agents.values())
        assert name not in first or row.floor.mean == first[name].floor.mean


def test_the_current_version_has_the_experts_of_the_cards_and_the_planner() -> None:
    for name, row in TASK_ROWS.items():
        task, best = TASKS[name], row.expert or row.attempts
        if task.base == "Navigation":
            assert row.expert is not None and row.expert.agent == "planner"
            continue
        assert best
        card = experts.card(task)
        assert (best.mean, best.policy) == (card.measurement.mean, card.policy)
        assert best.standard_error == card.measurement.standard_error
        assert row.expert is None or row.expert.provisional == card.provisional
        std = row.floor.agents[row.floor.agent].std
        is_clear = best.mean - row.floor.mean > experts.floor_margin(best.standard_error, std)
        assert (row.expert is not None) is is_clear
