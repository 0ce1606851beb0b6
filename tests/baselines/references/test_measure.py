"""Measurements for the references: their seeds, their stored results, and the published floors."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from gym_extensions.baselines.references.measure import Measurement, PendingMeasurement, measure
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.catalog.registry import task
from gym_extensions.scoring.references import CURRENT

PUBLISHED_LOGS = Path(__file__).parents[3] / "scoring" / "reference-logs" / CURRENT
TASKS = (task("Hopper"), task("Walker2dGravityOneAndQuarter"))


def test_a_measurement_uses_the_reference_seeds_and_is_not_repeated(tmp_path: Path) -> None:
    pending = PendingMeasurement(Measurement(TASKS[0], "random", 1000, 5), tmp_path)
    rows = pending.run(lambda _: None)
    expected = [evaluation_seed("reference", TASKS[0].id, episode) for episode in range(5)]
    assert [row.seed for row in rows] == expected
    (path,) = tmp_path.iterdir()
    content = json.loads(path.read_text())
    content["episodes"][0]["return_"] = 77.0
    path.write_text(json.dumps(content))
    assert pending.run(lambda _: None)[0].return_ == 77.0
    other_run = PendingMeasurement(Measurement(TASKS[0], "random", 1001, 5), tmp_path)
    assert [row.return_ for row in other_run.run(lambda _: None)] != [row.return_ for row in rows]


@pytest.mark.parametrize(
    ("agent", "key", "name"),
    [
        ("random", "versions", "numpy"),
        ("trpo", "hyperparameters", "max_kl"),
        ("oracle", "versions", "mujoco"),
    ],
)
def test_a_result_of_other_versions_or_settings_is_measured_again(
    tmp_path: Path, agent: str, key: str, name: str
) -> None:
    navigation = "State-Based-Navigation-2d-Map0-Goal0"
    which = task(navigation) if agent == "oracle" else TASKS[0]
    pending = PendingMeasurement(Measurement(which, agent, 1000, 2), tmp_path)
    rows = pending.run(lambda _: None)
    (path,) = tmp_path.iterdir()
    content = json.loads(path.read_text())
    content["episodes"][0]["return_"] = 77.0
    path.write_text(json.dumps(content))
    assert pending.run(lambda _: None)[0].return_ == 77.0
    content["settings"][key][name] = "0.0.1"
    path.write_text(json.dumps(content))
    assert pending.run(lambda _: None) == rows


def test_each_agent_and_task_has_its_own_seed() -> None:
    measurements = [Measurement(each, agent, 1000, 5) for each in TASKS for agent in ("random", "zero")]
    assert len({measurement.agent_seed for measurement in measurements}) == 4


def test_trpo_2017_has_the_seeds_of_the_published_ceilings_which_were_derived_from_its_earlier_name() -> None:
    for run in range(1000, 1005):
        seed = training_seed(run, "reference", TASKS[0].id, "trpo")
        assert Measurement(TASKS[0], "trpo-2017", run, 100, "100k").agent_seed == seed


@pytest.mark.parametrize("agent", ["random", "zero"])
def test_the_episodes_of_a_published_floor_can_be_reproduced(agent: str) -> None:
    """The first hundred, because they are one batch and so the same in a shorter measurement."""
    log = PUBLISHED_LOGS / "floors" / "Walker2dGravityOneAndQuarter-v0.csv"
    rows = [row for row in csv.DictReader(log.read_text().splitlines()) if row["agent"] == agent][:100]
    episodes = measure(Measurement(TASKS[1], agent, 1000, 100), lambda _: None)
    assert [(row.episode, row.seed, row.length, row.terminated) for row in episodes] == [
        (int(row["episode"]), int(row["seed"]), int(row["length"]), row["terminated"] == "true")
        for row in rows
    ]
    returns = [float(row["return"]) for row in rows]
    assert [row.return_ for row in episodes] == pytest.approx(returns, rel=1e-9)
