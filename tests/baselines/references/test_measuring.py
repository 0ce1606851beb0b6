"""References: their seeds, the formulas, and published floors again."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import msgspec
import pytest

from gym_extensions.baselines.experts.candidates import QUICK
from gym_extensions.baselines.references.measuring import (
    Measurement,
    differences,
    floor_of,
    is_open,
    published,
    read_file,
    summary,
    with_expert,
    with_runs,
)
from gym_extensions.catalog.tasks import task
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.references import Floor, FloorAgent, MeasuredReference, experts, parse_file, path_of

PUSHER = task("Pusher")
HOPPER = task("Hopper")
NAVIGATION = task("State-Based-Navigation-2d-Map0-Goal0")


def test_the_published_floors_and_experts_of_three_tasks_follow_from_seeds_and_files() -> None:
    assert differences([PUSHER, task("HopperGravityHalf"), NAVIGATION], path_of(), 0, QUICK) == []


def test_each_agent_and_task_has_its_own_seed() -> None:
    measurements = [Measurement(each, agent, 5) for each in (PUSHER, HOPPER) for agent in ("random", "zero")]
    assert len({measurement.agent_seed for measurement in measurements}) == 4


@pytest.mark.parametrize(
    ("beaten", "expected"),
    [
        # Of fewer than five runs all must beat the floor; of five or more, three.
        ([True], False),
        ([True, True, True, False], True),
        ([True, True, True, False, False], False),
        ([True, True, False, False, False], True),
    ],
)
def test_a_task_is_open_unless_enough_runs_beat_the_floor(beaten: list[bool], expected: bool) -> None:
    assert is_open(beaten) is expected


def test_a_summary_has_the_population_deviation() -> None:
    # 1, 2, 3, 6: mean 3, squared deviations 4 + 1 + 0 + 9 = 14 over 4.
    expected = FloorAgent(mean=3.0, std=math.sqrt(3.5), standard_error=math.sqrt(3.5) / 2)
    assert summary([1.0, 2.0, 3.0, 6.0]) == expected


def test_a_floor_is_the_mean_of_the_better_agent() -> None:
    random, zero = (Measurement(PUSHER, agent, 16) for agent in ("random", "zero"))
    floor = floor_of({random: [0.0, 2.0] * 8, zero: [3.0, 5.0] * 8})
    # Both have a standard deviation of 1, over √16.
    assert (floor.agent, floor.mean, floor.standard_error) == ("zero", 4.0, 0.25)
    assert {name: agent.mean for name, agent in floor.agents.items()} == {"random": 1.0, "zero": 4.0}
    assert floor.agents["zero"].seed == zero.agent_seed
    assert floor.fingerprint == fingerprint_of(PUSHER)


FLOOR = Floor(4.0, "zero", agents={"zero": FloorAgent(4.0, std=1.0)})


def test_the_expert_of_a_custom_task_is_the_mean_of_its_runs() -> None:
    row = with_runs(FLOOR, {1000: [30.0] * 20, 1001: [20.0] * 20}, "trpo", "100k")
    assert (row.floor, row.attempts) == (FLOOR, msgspec.UNSET)
    assert row.expert is not None
    # Two runs of 30 and 20: mean 25, sample standard deviation √50, over √2.
    assert (row.expert.mean, row.expert.episodes) == (25.0, 20)
    assert row.expert.standard_error == pytest.approx(5.0)
    assert ([run.run for run in row.expert.runs], row.expert.df) == ([1000, 1001], 1)


def test_an_open_custom_task_has_attempts_in_place_of_an_expert() -> None:
    row = with_runs(FLOOR, {1000: [6.0] * 100}, "trpo", "100k")  # two deviations of the floor above it
    assert (row.expert, bool(row.attempts)) == (None, True)
    assert row.attempts and not row.attempts.runs[0].beats_floor


def test_the_error_of_a_single_run_is_that_of_its_episodes() -> None:
    # A standard deviation of 2, over √16.
    expert = with_runs(FLOOR, {1000: [20.0, 24.0] * 8}, "planner").expert
    assert expert is not None
    assert (expert.mean, expert.standard_error, expert.runs) == (22.0, 0.5, [])


def test_the_published_file_is_made_from_floors_cards_and_the_planner(tmp_path: Path) -> None:
    made = published(tmp_path / "2.json", 0, tasks=[PUSHER, NAVIGATION])
    current = parse_file(path_of().read_bytes())
    assert made.tasks == {task.id: current.tasks[task.id] for task in (PUSHER, NAVIGATION)}


def test_a_task_is_open_without_an_expert_or_with_one_that_is_not_clear(tmp_path: Path) -> None:
    assert with_expert(HOPPER, FLOOR, tmp_path) == MeasuredReference(FLOOR, None)
    high = Floor(3700.0, "zero", agents={"zero": FloorAgent(3700.0, std=100.0)})
    row = with_expert(HOPPER, high)
    assert row.expert is None
    assert row.attempts and row.attempts.agent == "expert"


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"fingerprint": "0" * 16}, "foreign-fingerprint"),
        ({"policy": "0" * 64}, "other-policy"),
    ],
)
def test_an_expert_of_another_task_is_refused_and_nothing_is_written(
    change: dict[str, str], code: str, tmp_path: Path
) -> None:
    shutil.copy(experts.DATA / "Pusher.npz", tmp_path / "Pusher.npz")
    card = msgspec.structs.replace(experts.card("Pusher"), **change)
    (tmp_path / "Pusher.json").write_bytes(msgspec.json.encode(card))
    out = tmp_path / "out/2.json"
    with pytest.raises(BenchError, match="Pusher") as raised:
        published(out, 0, tmp_path, [PUSHER])
    assert raised.value.code == code
    assert not out.exists()


def test_a_floor_of_another_definition_of_the_task_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    stated = {"floor": {"mean": 0.0, "fingerprint": "0" * 16}, "expert": None}
    out.write_text(json.dumps({"format": 2, "version": "1", "tasks": {PUSHER.id: stated}}))
    with pytest.raises(BenchError, match=PUSHER.id) as error:
        read_file(out, [PUSHER])
    assert error.value.code == "foreign-fingerprint"
