"""Floors and ceilings: the rule for open tasks by hand, and a small measurement."""

from __future__ import annotations

import hashlib
import json
import math

import pytest

from gym_extensions.baselines.measuring import Measurement, MeasurementWork
from gym_extensions.baselines.references import beats_floor, is_open, summary, task_row
from gym_extensions.catalog.protocol import evaluation_seed

OPEN = [
    # Under five runs every one must pass; of five or more, three.
    ([True], False),
    ([True, False], True),
    ([True, True, True, False], True),
    ([True, True, True, False, False], False),
    ([True, True, False, False, False], True),
    ([False] * 5, True),
]


@pytest.mark.parametrize(("beaten", "expected"), OPEN)
def test_a_task_is_open_unless_enough_runs_beat_the_floor(beaten, expected):
    assert is_open(beaten) is expected


BEATS = [
    # floor 0 ± .3; the run's standard error .4: together .5, so that five of them are 2.5.
    (2.5, 2.0, True),
    (2.4, 2.0, False),
    # Above by errors, but not by a deviation of its own episodes.
    (2.9, 3.0, False),
    (3.0, 3.0, True),
]


@pytest.mark.parametrize(("mean", "std", "expected"), BEATS)
def test_a_run_beats_the_floor_by_five_errors_and_one_deviation(mean, std, expected):
    run = {"mean": mean, "std": std, "standard_error": 0.4}
    assert beats_floor(run, {"mean": 0.0, "std": 9.0, "standard_error": 0.3}) is expected


def test_a_summary_by_hand():
    # 1, 2, 3, 6: mean 3, squared deviations 4 + 1 + 0 + 9 = 14 over 4.
    found = summary([1.0, 2.0, 3.0, 6.0])
    assert found == {"mean": 3.0, "std": math.sqrt(3.5), "standard_error": math.sqrt(3.5) / 2}


def test_a_learned_task_has_the_mean_of_its_runs_and_the_better_floor():
    floors = {"random": [0.0, 2.0] * 10, "still": [3.0, 5.0] * 10}
    row = task_row(floors, {1001: [20.0] * 100, 1000: [30.0] * 100}, budget="100k", log_sha256="ab")
    assert row["floor"]["agent"] == "still"
    assert row["floor"]["mean"] == 4.0
    assert row["floor"]["agents"]["random"]["mean"] == 1.0
    assert row["open"] is False
    # Two runs of 30 and 20: mean 25, sample deviation √50, over √2.
    assert (row["ceiling"]["mean"], row["ceiling"]["standard_error"]) == (25.0, pytest.approx(5.0))
    assert [run["run"] for run in row["ceiling"]["runs"]] == [1000, 1001]
    assert "attempts" not in row


def test_an_open_task_has_no_ceiling_and_keeps_its_attempts():
    row = task_row({"random": [0.0], "still": [9.0]}, {1000: [8.0]}, budget="1M", log_sha256="ab")
    assert (row["ceiling"], row["open"]) == (None, True)
    assert row["attempts"]["runs"] == [{"run": 1000, "mean": 8.0, "std": 0.0, "beats_floor": False}]


def test_a_measurement_uses_the_reference_seeds_and_is_kept(tmp_path):
    task = "gym_extensions/Hopper-v0"
    work = MeasurementWork(Measurement(task, "random", 1000, 5), tmp_path)
    rows = work.run(lambda _: None)
    assert [row.seed for row in rows] == [evaluation_seed("reference", task, episode) for episode in range(5)]
    (part,) = tmp_path.iterdir()
    content = json.loads(part.read_text())
    content["episodes"][0]["return_"] = 77.0
    part.write_text(json.dumps(content))
    assert work.run(lambda _: None)[0].return_ == 77.0, "a finished part is not measured again"
    other = MeasurementWork(Measurement(task, "random", 1001, 5), tmp_path)
    assert [row.return_ for row in other.run(lambda _: None)] != [row.return_ for row in rows]


def test_the_command_writes_what_the_contracts_say(tmp_path, monkeypatch, capsys):
    from gym_extensions.baselines import references

    monkeypatch.setattr(references, "FLOOR_EPISODES", 4)
    monkeypatch.setattr(references, "CEILING_EPISODES", 3)
    out = tmp_path / "provisional.json"
    argv = ["--groups", "hopper-gravity", "--budget", "smoke", "--runs", "1000", "--out", str(out)]
    assert references.main(argv) == 0
    found = json.loads(out.read_text())
    assert (found["format"], found["version"], found["provisional"]) == (1, "provisional", True)
    assert len(found["tasks"]) == 5
    row = found["tasks"]["gym_extensions/Hopper-v0"]
    assert row["floor"]["episodes"] == 4
    measured = row["ceiling"] or row["attempts"]
    assert (measured["agent"], measured["budget"], measured["episodes"]) == ("trpo", "smoke", 3)
    log = tmp_path / "provisional-logs/Hopper-v0.csv"
    assert measured["log_sha256"] == hashlib.sha256(log.read_bytes()).hexdigest()
    assert len(log.read_text().splitlines()) == 1 + 3
    before = out.read_bytes()
    assert references.main(argv) == 0
    assert out.read_bytes() == before
