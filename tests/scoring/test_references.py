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

from gym_extensions.baselines.references.rows import beats_floor, is_unsolved, summary
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, evaluation_seed
from gym_extensions.scoring.references import CURRENT, REFERENCES, load_references, parse_references

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


def test_the_current_version_is_one_of_them() -> None:
    assert CURRENT in VERSIONS
    assert load_references() == load_references(CURRENT)


def test_a_file_of_another_format_does_not_load() -> None:
    with pytest.raises(ValueError, match=r"^References have format 1\.$"):
        parse_references(b'{"format": 2}')


@pytest.mark.parametrize("version", VERSIONS)
def test_each_log_belongs_to_a_task(version: str) -> None:
    ceilings, floors = (
        {f"{task.rpartition('/')[2]}.csv" for name, task in tasks if name == version}
        for tasks in (CEILINGS, TASKS)
    )
    found = {str(path.relative_to(LOGS / version)) for path in (LOGS / version).rglob("*.*")}
    assert found == ceilings | {f"floors/{name}" for name in floors}


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


@every_task
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
