"""Floors and ceilings: the rule for open tasks by hand, and a small measurement."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from pathlib import Path

import pytest

from gym_extensions.baselines.references.measure import Measurement, MeasurementWork, agent_seed, measure
from gym_extensions.baselines.references.rows import beats_floor, floor_row, is_open, summary, task_row
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.errors import BenchError
from gym_extensions.scoring.references import CURRENT

PUBLISHED_LOGS = Path(__file__).parents[3] / "scoring" / "reference-logs" / CURRENT


def files(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


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


def test_a_floor_is_that_of_the_better_agent_and_names_its_source():
    floor = floor_row(
        {"random": [0.0, 2.0] * 8, "still": [3.0, 5.0] * 8},
        {"random": 11, "still": 12},
        fingerprint="cd",
        log_sha256="ef",
    )
    # Both deviate by 1; over √16.
    spread = {"std": 1.0, "standard_error": 0.25}
    assert floor == {
        "mean": 4.0,
        "agent": "still",
        "budget": None,
        "run": 1000,
        "episodes": 16,
        "standard_error": 0.25,
        "agents": {
            "random": {"mean": 1.0, **spread, "seed": 11},
            "still": {"mean": 4.0, **spread, "seed": 12},
        },
        "fingerprint": "cd",
        "log_sha256": "ef",
    }


FLOOR = {"mean": 4.0, "standard_error": 0.25}
SOURCE = {"agent": "trpo", "budget": "100k", "log_sha256": "ab"}


def test_a_learned_task_has_the_mean_of_its_runs():
    row = task_row(FLOOR, {1001: [20.0] * 100, 1000: [30.0] * 100}, **SOURCE)
    assert (row["floor"], row["unsolved"]) == (FLOOR, False)
    # Two runs of 30 and 20: mean 25, sample deviation √50, over √2.
    assert (row["ceiling"]["mean"], row["ceiling"]["standard_error"]) == (25.0, pytest.approx(5.0))
    assert [run["run"] for run in row["ceiling"]["runs"]] == [1000, 1001]
    assert row["ceiling"] | SOURCE == row["ceiling"]
    assert "attempts" not in row


def test_an_open_task_has_no_ceiling_and_keeps_its_attempts():
    row = task_row(FLOOR, {1000: [3.0]}, **SOURCE)
    assert (row["ceiling"], row["unsolved"]) == (None, True)
    assert row["attempts"]["runs"] == [{"run": 1000, "mean": 3.0, "std": 0.0, "beats_floor": False}]


def test_one_run_has_the_error_of_its_episodes():
    row = task_row(FLOOR, {1000: [20.0, 24.0] * 8}, agent="oracle", budget="", log_sha256="ab")
    # They deviate by 2; over √16.
    assert (row["ceiling"]["mean"], row["ceiling"]["standard_error"]) == (22.0, 0.5)


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
    from gym_extensions.baselines.references import cli as references

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
    log = tmp_path / "provisional-logs/floors/Hopper-v0.csv"
    assert row["floor"]["log_sha256"] == hashlib.sha256(log.read_bytes()).hexdigest()
    header, *lines = log.read_text().splitlines()
    assert header == "agent,episode,seed,length,return,terminated"
    assert [line.split(",")[:2] for line in lines] == [
        [agent, str(episode)] for agent in ("random", "still") for episode in range(4)
    ]
    before = files(tmp_path)
    assert references.main(argv) == 0
    assert files(tmp_path) == before


def test_a_version_may_have_another_budget_for_each_group():
    from gym_extensions.baselines.references.cli import budgets_of
    from gym_extensions.catalog.groups import group

    hopper, pusher = (dict.fromkeys(group(name).task_ids) for name in ("hopper-gravity", "pusher"))
    assert budgets_of("hopper-gravity, pusher", "1M") == dict.fromkeys([*hopper, *pusher], "1M")
    found = budgets_of("hopper-gravity,pusher", "1M,100k")
    assert found == dict.fromkeys(hopper, "1M") | dict.fromkeys(pusher, "100k")
    assert list(found) == [*hopper, *pusher]


@pytest.mark.parametrize(
    ("groups", "budgets", "text"),
    [
        (
            "hopper-gravity,pusher",
            "1M,1M,100k",
            "--budget: 2 groups have 3 budgets. Give one for all groups, or one a group.",
        ),
        (
            "hopper-gravity,hopper-motor-noise",
            "1M,100k",
            "--budget: gym_extensions/Hopper-v0 is in two of the groups, with the budgets 1M and 100k. "
            "Give these groups the same budget.",
        ),
        ("hopper-gravity", "2M", "There is no budget '2M'. Choose one of: 100k, 1M, paper, smoke."),
    ],
)
def test_budgets_that_do_not_fit_are_refused(groups, budgets, text):
    from gym_extensions.baselines.references.cli import budgets_of

    with pytest.raises(BenchError) as caught:
        budgets_of(groups, budgets)
    assert str(caught.value) == text


@pytest.mark.parametrize("agent", ["random", "still"])
def test_the_published_floors_episodes_come_out_again(agent):
    """The first hundred: the lanes of one batch, so that they are the same in a shorter measurement."""
    task = "gym_extensions/HopperGravityHalf-v0"
    log = PUBLISHED_LOGS / "floors" / "HopperGravityHalf-v0.csv"
    rows = [row for row in csv.DictReader(log.read_text().splitlines()) if row["agent"] == agent][:100]
    again = measure(Measurement(task, agent, 1000, 100), lambda _: None)
    assert [(row.episode, row.seed, row.length, row.terminated) for row in again] == [
        (int(row["episode"]), int(row["seed"]), int(row["length"]), row["terminated"] == "true")
        for row in rows
    ]
    assert [row.return_ for row in again] == pytest.approx([float(row["return"]) for row in rows], rel=1e-9)


def test_each_agent_and_task_has_a_seed_of_its_own():
    tasks = ("gym_extensions/Hopper-v0", "gym_extensions/HopperGravityHalf-v0")
    wanted = [Measurement(task, agent, 1000, 5) for task in tasks for agent in ("random", "still")]
    assert len({agent_seed(each) for each in wanted}) == 4
