"""The frozen references: every ceiling can be computed again from the log that its hash names."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, evaluation_seed
from gym_extensions.scoring.normalise import CURRENT, REFERENCES

LOGS = Path(__file__).parents[2] / "scoring" / "reference-logs" / CURRENT
TASKS: dict[str, Any] = json.loads((REFERENCES / f"{CURRENT}.json").read_text())["tasks"]


@pytest.mark.parametrize("task", TASKS)
def test_a_reference_is_what_its_log_says(task: str) -> None:
    row = TASKS[task]
    claimed = row["ceiling"] or row["attempts"]
    log = (LOGS / f"{task.rpartition('/')[2]}.csv").read_bytes()
    assert hashlib.sha256(log).hexdigest() == claimed["log_sha256"]
    episodes = list(csv.DictReader(log.decode().splitlines()))
    assert {one["fingerprint"] for one in episodes} == {published(task)}
    for run in claimed["runs"]:
        own = [one for one in episodes if int(one["run"]) == run["run"] >= FIRST_REFERENCE_RUN]
        assert [int(one["seed"]) for one in own] == [
            evaluation_seed("reference", task, episode) for episode in range(claimed["episodes"])
        ]
        returns = [float(one["return"]) for one in own]
        assert math.fsum(returns) / len(returns) == run["mean"]
    means = [run["mean"] for run in claimed["runs"]]
    assert claimed["mean"] == math.fsum(means) / len(means)


@pytest.mark.parametrize("task", TASKS)
def test_the_floor_is_the_better_of_two_agents_that_look_at_nothing(task: str) -> None:
    floor = TASKS[task]["floor"]
    assert floor["mean"] == max(agent["mean"] for agent in floor["agents"].values())
    assert sorted(floor["agents"]) == ["random", "still"]


@pytest.mark.parametrize("task", TASKS)
def test_with_two_runs_a_task_is_open_unless_both_beat_the_floor(task: str) -> None:
    row = TASKS[task]
    runs = (row["ceiling"] or row["attempts"])["runs"]
    assert len(runs) == 2
    assert row["open"] is not all(run["beats_floor"] for run in runs)
