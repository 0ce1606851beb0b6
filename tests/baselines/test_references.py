"""References of custom groups: their seeds, the formulas, and ``gym-extensions maintain references``."""

import json
import math
from pathlib import Path

import msgspec
import pytest

from gym_extensions.baselines import references
from gym_extensions.baselines.references import Measurement, floor_of, is_open, read_file, summary, with_runs
from gym_extensions.baselines.training.runner import StageRun
from gym_extensions.catalog.tasks import task
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.references import Floor, FloorAgent, parse_references, path_of

from ..conftest import refused

PUSHER = task("Pusher")
HOPPER = task("Hopper")


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


def test_a_floor_of_another_definition_of_the_task_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    stated = {"floor": {"mean": 0.0, "fingerprint": "0" * 16}, "expert": None}
    out.write_text(json.dumps({"format": 2, "version": "1", "tasks": {PUSHER.id: stated}}))
    with refused("foreign-fingerprint", PUSHER.id):
        read_file(out, [PUSHER])


@pytest.mark.usefixtures("quick")
def test_an_interrupted_measurement_of_custom_groups_trains_nothing_twice(
    quick_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "mine.json"
    command = ["--groups", str(quick_file), "--budget", "smoke", "--runs", "1000", "--out", str(out)]
    with monkeypatch.context() as patch, pytest.raises(TypeError):
        patch.setattr(references, "with_runs", None)
        references.main(command)
    assert len(list((tmp_path / ".progress/mine").rglob("stage1.json"))) == 2
    monkeypatch.setattr(StageRun, "_train", None)
    assert references.main(command) == 0
    assert not (tmp_path / ".progress").exists()
    rows = parse_references(out.read_bytes()).tasks.values()
    found = [(best.agent, best.budget) for row in rows if (best := row.expert or row.attempts)]
    assert found == [("trpo", "smoke")] * 2


def test_published_references_are_not_replaced(capsys: pytest.CaptureFixture[str]) -> None:
    before = path_of().read_bytes()
    assert references.main(["--groups", "pusher", "--out", str(path_of())]) == 2
    assert "published references, which never change" in capsys.readouterr().err
    assert path_of().read_bytes() == before


@pytest.mark.usefixtures("quick")
def test_tasks_of_a_file_stay_and_published_ones_are_not_measured(quick_file: Path, tmp_path: Path) -> None:
    out, mixed = tmp_path / "mine.json", tmp_path / "mixed.toml"
    tasks = ["", "max_steps = 10", "max_steps = 11"]  # the first is published, the second one of quick_file
    mixed.write_text('name = "mixed"\n' + "".join(f'[[tasks]]\ntask = "Pusher"\n{each}\n' for each in tasks))
    options = ["--budget", "smoke", "--runs", "1000", "--agent", "random", "--out", str(out)]
    assert references.main(["--groups", str(quick_file), *options]) == 0
    before = json.loads(out.read_text())["tasks"]
    assert references.main(["--groups", str(mixed), *options]) == 0
    after = json.loads(out.read_text())["tasks"]
    assert {name: after[name] for name in before} == before
    assert after.keys() - before.keys() == {"gym_extensions/Pusher.steps-11-v0"}


@pytest.mark.parametrize("text", ["{", "[]", '{"format": 3, "version": "1", "tasks": {}}'])
def test_a_file_that_does_not_hold_references_is_not_replaced(text: str, tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    out.write_text(text)
    assert references.main(["--groups", "pusher", "--out", str(out)]) == 2
    assert out.read_text() == text
