"""The frozen references: every floor and ceiling can be computed again from the log that its hash names."""

from __future__ import annotations

import csv
import hashlib
import json
import math
import statistics
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines.references import beats_floor, is_unsolved, summary
from gym_extensions.baselines.training.jobs import training_seed
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, evaluation_seed
from gym_extensions.errors import BenchError
from gym_extensions.scoring.references import (
    REFERENCES,
    Reference,
    add_references,
    load_references,
    parse_references,
    read_references,
    require_references,
)

LOGS = Path(__file__).parents[2] / "scoring" / "reference-logs"
VERSIONS = sorted(path.stem for path in REFERENCES.glob("*.json"))
FILES: dict[str, Any] = {
    version: json.loads((REFERENCES / f"{version}.json").read_text()) for version in VERSIONS
}
TASKS = [(version, task) for version in VERSIONS for task in FILES[version]["tasks"]]
CEILINGS = [(version, task) for version, task in TASKS if "ceiling" in FILES[version]["tasks"][task]]
every_task = pytest.mark.parametrize(("version", "task"), TASKS)
every_ceiling = pytest.mark.parametrize(("version", "task"), CEILINGS)


def row_of(version: str, task: str) -> dict[str, Any]:
    found: dict[str, Any] = FILES[version]["tasks"][task]
    return found


def episodes_of(log: Path, digest: str) -> list[dict[str, str]]:
    """The rows of a log whose bytes are those of the digest."""
    data = log.read_bytes()
    assert hashlib.sha256(data).hexdigest() == digest
    return list(csv.DictReader(data.decode().splitlines()))


def prescribed(task: str, count: int) -> list[int]:
    return [evaluation_seed("reference", task, episode) for episode in range(count)]


@pytest.mark.parametrize("version", VERSIONS)
def test_every_version_loads(version: str) -> None:
    found = load_references(version)
    assert found.version == version
    assert list(found.tasks) == [task for name, task in CEILINGS if name == version] != []
    assert found.digest == hashlib.sha256((REFERENCES / f"{version}.json").read_bytes()).hexdigest()


HOPPER, HUMANOID = "gym_extensions/Hopper-v0", "gym_extensions/Humanoid-v0"
TASK = {
    "floor": {"mean": 10, "agents": {"random": {"mean": 3}, "zero": {"mean": 10}}},
    "ceiling": {"mean": 30.5},
}
UNSOLVED = {"floor": {"mean": 1}, "ceiling": None, "unsolved": True}
NOT_MEASURED = {"floor": {"mean": 1}, "unsolved": False}


def a_file(**changes: object) -> bytes:
    """The bytes of a references file."""
    return json.dumps({"format": 1, "version": "v1", "tasks": {HOPPER: TASK}} | changes).encode()


def test_references_are_read_and_pinned_by_their_bytes() -> None:
    data = a_file(tasks={HOPPER: TASK, HUMANOID: UNSOLVED, "gym_extensions/Pusher-v0": NOT_MEASURED})
    found = parse_references(data)
    assert found.version == "v1"
    assert found.tasks == {
        HOPPER: Reference(10.0, 30.5, False, {"random": 3.0, "zero": 10.0}),
        HUMANOID: Reference(1.0, None, True),
    }
    assert found.missing([HOPPER, "gym_extensions/Pusher-v0"]) == ["gym_extensions/Pusher-v0"]
    assert found.digest != parse_references(data + b"\n").digest


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"[1]", "object"),
        (b"{", "truncated"),
        (a_file(format=2), "format"),
        (a_file(tasks=[]), "tasks"),
        (a_file(tasks={HOPPER: {"ceiling": {"mean": 1}}}), "floor"),
        (a_file(tasks={HOPPER: TASK | {"ceiling": {"mean": 10}}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"ceiling": {"mean": 9}}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"unsolved": True}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"ceiling": None}}), HOPPER),
        (a_file(tasks={HOPPER: TASK | {"floor": {"mean": math.nan}}}), "JSON"),
        (a_file().replace(b"30.5", b"1e999"), ""),
    ],
)
def test_a_file_that_holds_no_references_is_an_error_that_says_where(
    data: bytes, told: str, tmp_path: Path
) -> None:
    path = tmp_path / "r.json"
    path.write_bytes(data)
    with pytest.raises(BenchError) as raised:
        read_references(path)
    assert raised.value.code == "malformed-references"
    assert told in str(raised.value)
    assert "r.json" in str(raised.value)


@pytest.mark.parametrize(
    "reference",
    [
        (0.0, 0.0, False),
        (0.0, None, False),
        (0.0, 1.0, True),
        (math.nan, 1.0, False),
        (0.0, math.inf, False),
        (0.0, 1.0, False, {"zero": math.nan}),
    ],
)
def test_a_reference_needs_finite_numbers_and_a_span(reference: Any) -> None:
    with pytest.raises(ValueError, match=r"it is|not"):
        Reference(*reference)


def test_every_task_of_a_group_needs_a_reference() -> None:
    found = parse_references(a_file())
    require_references(found, "mine", [HOPPER], "r.json")
    with pytest.raises(BenchError) as raised:
        require_references(found, "mine", [HOPPER, HUMANOID], "r.json")
    assert raised.value.code == "missing-reference"
    assert HUMANOID in str(raised.value)


def test_own_references_add_tasks_and_replace_none() -> None:
    own = parse_references(a_file(tasks={HOPPER: TASK | {"ceiling": {"mean": 99}}, HUMANOID: UNSOLVED}))
    both = add_references(parse_references(a_file()), own)
    assert both.tasks[HOPPER].ceiling == 30.5
    assert both.tasks[HUMANOID].unsolved
    assert both.version == "v1 + v1"


@pytest.mark.parametrize("version", VERSIONS)
def test_each_log_belongs_to_a_task(version: str) -> None:
    ceilings, floors = (
        {f"{task.rpartition('/')[2]}.csv" for name, task in tasks if name == version}
        for tasks in (CEILINGS, TASKS)
    )
    found = {str(path.relative_to(LOGS / version)) for path in (LOGS / version).rglob("*.*")}
    assert ceilings <= found <= ceilings | {f"floors/{name}" for name in floors}


@every_ceiling
def test_a_ceiling_is_what_its_log_says(version: str, task: str) -> None:
    row = row_of(version, task)
    claimed = row["ceiling"] or row["attempts"]
    episodes = episodes_of(LOGS / version / f"{task.rpartition('/')[2]}.csv", claimed["log_sha256"])
    assert {one["fingerprint"] for one in episodes} == {published(task)}
    assert sorted({int(one["run"]) for one in episodes}) == [run["run"] for run in claimed["runs"]]
    for run in claimed["runs"]:
        own = [one for one in episodes if int(one["run"]) == run["run"] >= FIRST_REFERENCE_RUN]
        assert [int(one["seed"]) for one in own] == prescribed(task, claimed["episodes"])
        again = summary([float(one["return"]) for one in own])
        assert (run["mean"], run["std"]) == (again["mean"], again["std"])
        assert run["beats_floor"] is beats_floor(again, row["floor"])
    means = [run["mean"] for run in claimed["runs"]]
    assert claimed["mean"] == math.fsum(means) / len(means)
    error = again["standard_error"] if len(means) == 1 else statistics.stdev(means) / math.sqrt(len(means))
    assert claimed["standard_error"] == pytest.approx(error, rel=1e-12)


FLOORS = [
    (version, task)
    for version, task in TASKS
    if (LOGS / version / "floors" / f"{task.rpartition('/')[2]}.csv").exists()
]


@pytest.mark.parametrize(("version", "task"), FLOORS)
def test_a_floor_is_what_its_log_says(version: str, task: str) -> None:
    floor = row_of(version, task)["floor"]
    log = LOGS / version / "floors" / f"{task.rpartition('/')[2]}.csv"
    episodes = episodes_of(log, floor["log_sha256"])
    assert {one["agent"] for one in episodes} == set(floor["agents"])
    for agent, claimed in floor["agents"].items():
        own = [one for one in episodes if one["agent"] == agent]
        assert [int(one["episode"]) for one in own] == list(range(floor["episodes"]))
        assert [int(one["seed"]) for one in own] == prescribed(task, floor["episodes"])
        assert all(int(one["length"]) >= 1 and one["terminated"] in {"true", "false"} for one in own)
        returns = [float(one["return"]) for one in own]
        assert claimed["mean"] == math.fsum(returns) / len(returns)
        std = statistics.pstdev(returns)
        assert claimed["std"] == pytest.approx(std, rel=1e-9)
        assert claimed["standard_error"] == pytest.approx(std / math.sqrt(len(returns)), rel=1e-9)
        assert claimed["seed"] == training_seed(floor["run"], "reference", task, agent)


@every_task
def test_the_floor_is_the_better_of_two_agents_that_look_at_nothing(version: str, task: str) -> None:
    floor = row_of(version, task)["floor"]
    assert sorted(floor["agents"]) == ["random", "zero"]
    assert floor["mean"] == max(agent["mean"] for agent in floor["agents"].values())
    better = floor["agents"][floor["agent"]]
    assert (floor["mean"], floor["standard_error"]) == (better["mean"], better["standard_error"])
    assert (floor["budget"], floor["run"]) == (None, FIRST_REFERENCE_RUN)
    assert floor["fingerprint"] == published(task)


@every_ceiling
def test_a_task_is_unsolved_by_the_rule_and_then_without_a_ceiling(version: str, task: str) -> None:
    row = row_of(version, task)
    runs = (row["ceiling"] or row["attempts"])["runs"]
    assert row["unsolved"] is is_unsolved([run["beats_floor"] for run in runs])
    assert (row["ceiling"] is None) is row["unsolved"] is ("attempts" in row)
