"""References: their seeds, stored measurements, the formulas, the command, and published floors again."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import references
from gym_extensions.baselines.execution.workers import ThisProcess
from gym_extensions.baselines.references import (
    Measurement,
    beats_floor,
    changed_floors,
    existing_tasks,
    floor_of,
    is_unsolved,
    references_of,
    summary,
    task_budgets,
)
from gym_extensions.baselines.training.jobs import training_seed
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.catalog.tasks import task
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.tables import Episode

PUBLISHED = Path(references.__file__).parents[3] / ("scoring/gym_extensions/scoring/references_data/1.json")
PUSHER = task("Pusher")
NAVIGATION = task("State-Based-Navigation-2d-Map0-Goal0")


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few episodes, in this process."""
    monkeypatch.setattr(references, "FLOOR_EPISODES", 4)
    monkeypatch.setattr(references, "CEILING_EPISODES", 3)
    monkeypatch.setattr(references, "Workers", lambda _: ThisProcess())


def returns(measurement: Measurement) -> list[float]:
    return [episode.return_ for episode in measurement.run_or_load(lambda _: None)]


def test_the_published_floors_of_two_tasks_follow_from_their_seeds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(references, "Workers", lambda _: ThisProcess())
    assert changed_floors([PUSHER, NAVIGATION], PUBLISHED, 1) == []


@pytest.mark.usefixtures("quick")
def test_a_floor_of_other_episodes_is_found(tmp_path: Path) -> None:
    document = json.loads(PUBLISHED.read_bytes())
    for agent in document["tasks"][PUSHER.id]["floor"]["agents"].values():
        agent["mean"] = -1.0
    path = tmp_path / "1.json"
    path.write_text(json.dumps(document))
    command = ["--groups", "pusher", "--check", str(path)]
    assert references.main(command) == 1
    assert changed_floors([PUSHER], path, 1) == [PUSHER.id]


def test_a_measurement_uses_the_reference_seeds_and_is_not_repeated(tmp_path: Path) -> None:
    measurement = Measurement(PUSHER, "random", 1000, 5, folder=tmp_path)
    episodes = measurement.run_or_load(lambda _: None)
    expected = [evaluation_seed("reference", PUSHER.id, episode) for episode in range(5)]
    assert [episode.seed for episode in episodes] == expected
    (path,) = tmp_path.iterdir()
    content = json.loads(path.read_text())
    content["episodes"][0]["return_"] = 77.0
    path.write_text(json.dumps(content))
    assert returns(measurement)[0] == 77.0


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
    which = NAVIGATION if agent == "oracle" else PUSHER
    measurement = Measurement(which, agent, 1000, 2, folder=tmp_path)
    first = returns(measurement)
    (path,) = tmp_path.iterdir()
    content = json.loads(path.read_text())
    content["episodes"][0]["return_"] = 77.0
    content["settings"][key][name] = "0.0.1"
    path.write_text(json.dumps(content))
    assert returns(measurement) == first


def test_each_agent_task_and_run_has_its_own_seed() -> None:
    measurements = [
        Measurement(each, agent, run, 5)
        for each in (PUSHER, NAVIGATION)
        for agent in ("random", "zero")
        for run in (1000, 1001)
    ]
    assert len({measurement.agent_seed for measurement in measurements}) == 8


def test_trpo_2017_has_the_seeds_of_the_published_ceilings_which_were_derived_from_its_earlier_name() -> None:
    seed = training_seed(1000, "reference", PUSHER.id, "trpo")
    assert Measurement(PUSHER, "trpo-2017", 1000, 100, "100k").agent_seed == seed


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
def test_a_task_is_unsolved_unless_enough_runs_beat_the_floor(beaten: list[bool], expected: bool) -> None:
    assert is_unsolved(beaten) is expected


@pytest.mark.parametrize(
    ("mean", "std", "expected"),
    [
        # The floor is 0 ± 0.3 and the run's standard error 0.4: together 0.5, five times which is 2.5.
        (2.5, 2.0, True),
        (2.4, 2.0, False),
        # Above by five standard errors, but not by one standard deviation of its episodes.
        (2.9, 3.0, False),
        (3.0, 3.0, True),
    ],
)
def test_a_run_beats_the_floor_by_five_errors_and_one_deviation(
    mean: float, std: float, expected: bool
) -> None:
    run = {"mean": mean, "std": std, "standard_error": 0.4}
    assert beats_floor(run, {"mean": 0.0, "std": 9.0, "standard_error": 0.3}) is expected


def test_a_summary_has_the_population_deviation() -> None:
    # 1, 2, 3, 6: mean 3, squared deviations 4 + 1 + 0 + 9 = 14 over 4.
    expected = {"mean": 3.0, "std": math.sqrt(3.5), "standard_error": math.sqrt(3.5) / 2}
    assert summary([1.0, 2.0, 3.0, 6.0]) == expected


def episodes(*values: float) -> list[Episode]:
    return [Episode(1, PUSHER.id, number, 0, 100, value, False, None) for number, value in enumerate(values)]


def test_a_floor_is_the_mean_of_the_better_agent() -> None:
    random, zero = (Measurement(PUSHER, agent, 1000, 16) for agent in ("random", "zero"))
    floor = floor_of(PUSHER, {random: episodes(*[0.0, 2.0] * 8), zero: episodes(*[3.0, 5.0] * 8)})
    # Both have a standard deviation of 1, over √16.
    assert (floor["agent"], floor["mean"], floor["standard_error"]) == ("zero", 4.0, 0.25)
    assert {name: agent["mean"] for name, agent in floor["agents"].items()} == {"random": 1.0, "zero": 4.0}
    assert floor["agents"]["zero"]["seed"] == zero.agent_seed
    assert floor["fingerprint"] == fingerprint_of(PUSHER)


FLOOR = {"mean": 4.0, "standard_error": 0.25}


def references_from(runs: dict[int, list[float]], agent: str = "trpo") -> dict[str, Any]:
    measurements = {Measurement(PUSHER, agent, run, 2, "100k"): episodes(*runs[run]) for run in runs}
    return references_of(FLOOR, list(measurements), measurements)


def test_the_ceiling_of_a_solved_task_is_the_mean_of_its_runs() -> None:
    solved = references_from({1001: [20.0] * 100, 1000: [30.0] * 100})
    assert (solved["floor"], solved["unsolved"], "attempts" in solved) == (FLOOR, False, False)
    # Two runs of 30 and 20: mean 25, sample standard deviation √50, over √2.
    assert (solved["ceiling"]["mean"], solved["ceiling"]["standard_error"]) == (25.0, pytest.approx(5.0))
    assert [run["run"] for run in solved["ceiling"]["runs"]] == [1000, 1001]


def test_an_unsolved_task_has_attempts_in_place_of_a_ceiling() -> None:
    unsolved = references_from({1000: [3.0]})
    assert (unsolved["ceiling"], unsolved["unsolved"]) == (None, True)
    assert unsolved["attempts"]["runs"] == [{"run": 1000, "mean": 3.0, "std": 0.0, "beats_floor": False}]


def test_the_error_of_a_single_run_is_that_of_its_episodes() -> None:
    # A standard deviation of 2, over √16.
    ceiling = references_from({1000: [20.0, 24.0] * 8}, "oracle")["ceiling"]
    assert (ceiling["mean"], ceiling["standard_error"]) == (22.0, 0.5)


@pytest.mark.usefixtures("quick")
def test_ceilings_are_added_to_the_floors_of_an_existing_file(
    quick_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grown, at_once = tmp_path / "grown/1.json", tmp_path / "at-once/1.json"
    command = ["--groups", str(quick_file), "--budget", "smoke", "--runs", "1000"]
    assert references.main([*command, "--out", str(grown), "--floors-only"]) == 0
    floors = json.loads(grown.read_text())["tasks"]
    assert [list(each) for each in floors.values()] == [["floor"], ["floor"]]
    shutil.rmtree(tmp_path / "grown/.progress")
    with monkeypatch.context() as patch:
        patch.setattr(references, "floor_measurements", None)
        assert references.main([*command, "--out", str(grown)]) == 0
    assert references.main([*command, "--out", str(at_once)]) == 0
    assert grown.read_text() == at_once.read_text()
    measured = json.loads(grown.read_text())["tasks"].values()
    assert {(each["ceiling"] or each["attempts"])["budget"] for each in measured} == {"smoke"}


@pytest.mark.usefixtures("quick")
def test_tasks_that_another_process_adds_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other, out = tmp_path / "other/mine.json", tmp_path / "mine.json"
    options = ["--budget", "smoke", "--runs", "1000", "--floors-only", "--out"]
    assert references.main(["--groups", "pusher-tracking", *options, str(other)]) == 0

    class Meanwhile(ThisProcess):
        def run(self, pending: Any, listen: Any) -> Any:
            shutil.copyfile(other, out)
            yield from super().run(pending, listen)

    monkeypatch.setattr(references, "Workers", Meanwhile)
    assert references.main(["--groups", "striker-tracking", *options, str(out)]) == 0
    assert len(json.loads(out.read_text())["tasks"]) == 4


def test_a_floor_of_another_definition_of_the_task_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    stated = {"floor": {"mean": 0.0, "fingerprint": "0" * 16}}
    out.write_text(json.dumps({"format": 1, "tasks": {PUSHER.id: stated}}))
    with pytest.raises(BenchError, match=PUSHER.id) as error:
        existing_tasks(out, [PUSHER])
    assert error.value.code == "foreign-fingerprint"


@pytest.mark.parametrize("text", ["{", "[]", '{"format": 2, "tasks": {}}'])
def test_a_file_that_does_not_hold_references_is_not_replaced(text: str, tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    out.write_text(text)
    assert references.main(["--groups", "pusher", "--out", str(out)]) == 2
    assert out.read_text() == text


def test_the_ceilings_are_measured_with_the_named_agent_or_the_oracle() -> None:
    runs = references.ceiling_measurements(PUSHER, "1M", [1000, 1001], "trpo-2017")
    assert [(each.agent, each.run) for each in runs] == [("trpo-2017", 1000), ("trpo-2017", 1001)]
    assert [each.agent for each in references.ceiling_measurements(NAVIGATION, "1M", [1000])] == ["oracle"]


def test_each_group_may_have_its_own_budget() -> None:
    hopper, pusher = group("hopper-gravity").tasks, group("pusher").tasks
    assert task_budgets("hopper-gravity, pusher", "1M") == dict.fromkeys([*hopper, *pusher], "1M")
    budgets = task_budgets("hopper-gravity,pusher", "1M,100k")
    assert budgets == dict.fromkeys(hopper, "1M") | dict.fromkeys(pusher, "100k")


@pytest.mark.parametrize(
    ("groups", "budgets"),
    [
        ("hopper-gravity,pusher", "1M,1M,100k"),
        ("hopper-gravity,hopper-motor-noise", "1M,100k"),  # both have Hopper
        ("hopper-gravity", "2M"),
    ],
)
def test_budgets_that_do_not_match_the_groups_are_rejected(groups: str, budgets: str) -> None:
    with pytest.raises(BenchError):
        task_budgets(groups, budgets)
