"""The command ``gym-extensions reference``."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines.execution.workers import ThisProcess
from gym_extensions.baselines.references import cli, content
from gym_extensions.baselines.references.existing import existing_rows, is_provisional
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.registry import task
from gym_extensions.errors import BenchError
from gym_extensions.scoring.references import parse_references

from ..conftest import digests


def files(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def load_tasks(path: Path) -> list[str]:
    return list(parse_references(path.read_bytes()).tasks)


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_the_command_writes_the_references_and_their_logs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(content, "FLOOR_EPISODES", 4)
    monkeypatch.setattr(content, "CEILING_EPISODES", 3)
    out = tmp_path / "provisional.json"
    argv = ["--groups", "hopper-motor-noise", "--budget", "smoke", "--runs", "1000", "--out", str(out)]
    assert cli.main(argv) == 0
    document = json.loads(out.read_text())
    assert (document["format"], document["version"], document["provisional"]) == (1, "provisional", True)
    assert len(document["tasks"]) == 2
    row = document["tasks"]["gym_extensions/Hopper-v0"]
    assert row["floor"]["episodes"] == 4
    trained = row["ceiling"] or row["attempts"]
    assert (trained["agent"], trained["budget"], trained["episodes"]) == ("trpo", "smoke", 3)
    log = tmp_path / "provisional-logs/Hopper-v0.csv"
    assert trained["log_sha256"] == sha256(log)
    assert len(log.read_text().splitlines()) == 1 + 3
    log = tmp_path / "provisional-logs/floors/Hopper-v0.csv"
    assert row["floor"]["log_sha256"] == sha256(log)
    header, *lines = log.read_text().splitlines()
    assert header == "agent,episode,seed,length,return,terminated"
    assert [line.split(",")[:2] for line in lines] == [
        [agent, str(episode)] for agent in ("random", "zero") for episode in range(4)
    ]
    before = files(tmp_path)
    assert cli.main(argv) == 0
    assert files(tmp_path) == before


def test_ceilings_are_added_to_the_floors_of_an_existing_file(
    quick_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In this process; the test above starts workers."""
    monkeypatch.setattr(content, "FLOOR_EPISODES", 4)
    monkeypatch.setattr(content, "CEILING_EPISODES", 3)
    monkeypatch.setattr(content, "Workers", lambda _: ThisProcess())
    grown, at_once = tmp_path / "grown/1.json", tmp_path / "at-once/1.json"
    command = ["--groups", str(quick_file), "--budget", "smoke", "--runs", "1000"]
    assert cli.main([*command, "--out", str(grown), "--floors-only"]) == 0
    floors = json.loads(grown.read_text())["tasks"]
    assert [sorted(row) for row in floors.values()] == [["floor"], ["floor"]]
    assert load_tasks(grown) == []
    shutil.rmtree(tmp_path / "grown/.progress")
    with monkeypatch.context() as patch:
        patch.setattr(content, "floor_measurements", None)
        assert cli.main([*command, "--out", str(grown)]) == 0
    assert cli.main([*command, "--out", str(at_once)]) == 0
    assert load_tasks(grown) == list(floors)
    assert grown.read_text() == at_once.read_text()
    assert digests(tmp_path / "grown") == digests(tmp_path / "at-once")


def test_a_floor_of_another_definition_of_the_task_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    row = {"floor": {"mean": 0.0, "fingerprint": "0" * 16}}
    out.write_text(json.dumps({"format": 1, "tasks": {"gym_extensions/Pusher-v0": row}}))
    with pytest.raises(BenchError) as error:
        existing_rows(out, group("pusher").tasks)
    assert str(error.value) == (
        f"{out}: The floor of gym_extensions/Pusher-v0 was measured with another definition of the task. "
        "Start a new version with --out."
    )


def test_a_place_that_cannot_be_written_is_refused_before_anything_is_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("x")
    for out, message in {
        tmp_path / "file" / "1.json": "The folder is not writable: ",
        tmp_path: "It is a folder. Name a file, such as references.json.",
    }.items():
        assert cli.main(["--groups", "pusher", "--budget", "smoke", "--out", str(out)]) == 2
        assert message in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("text", ["{", "[]", '{"format": 2, "tasks": {}}'])
def test_a_file_that_does_not_hold_references_is_not_replaced(text: str, tmp_path: Path) -> None:
    out = tmp_path / "1.json"
    out.write_text(text)
    with pytest.raises(BenchError, match=r"The file does not hold references\. Name another file"):
        existing_rows(out, [])
    assert out.read_text() == text


@pytest.mark.parametrize(
    ("agent", "budget", "runs", "expected"),
    [
        ("trpo", "300k", 5, False),
        ("trpo", "300k", 4, True),
        ("trpo", "100k", 5, True),
        ("oracle", "", 1, False),
    ],
)
def test_references_are_provisional_with_few_runs_or_another_budget(
    agent: str, budget: str, runs: int, expected: bool
) -> None:
    final = {"agent": "trpo", "budget": "300k", "runs": [0] * 5}
    row = {"agent": agent, "budget": budget, "runs": [0] * runs}
    rows: list[dict[str, object]] = [{"floor": {}}, {"ceiling": final}, {"ceiling": None, "attempts": row}]
    assert is_provisional(rows) is expected


@pytest.mark.parametrize("agent", ["trpo", "trpo-2017"])
def test_the_ceilings_are_measured_with_the_named_agent(agent: str) -> None:
    runs = content.ceiling_measurements(task("Hopper"), "1M", [1000, 1001], agent)
    assert [(each.agent, each.run) for each in runs] == [(agent, 1000), (agent, 1001)]
    oracle = content.ceiling_measurements(group("nav-state").tasks[0], "1M", [1000, 1001], agent)
    assert [each.agent for each in oracle] == ["oracle"]


def test_each_group_may_have_its_own_budget() -> None:
    hopper, pusher = group("hopper-gravity").tasks, group("pusher").tasks
    assert cli.task_budgets("hopper-gravity, pusher", "1M") == dict.fromkeys([*hopper, *pusher], "1M")
    budgets = cli.task_budgets("hopper-gravity,pusher", "1M,100k")
    assert budgets == dict.fromkeys(hopper, "1M") | dict.fromkeys(pusher, "100k")
    assert list(budgets) == [*hopper, *pusher]


@pytest.mark.parametrize(
    ("groups", "budgets", "message"),
    [
        (
            "hopper-gravity,pusher",
            "1M,1M,100k",
            "--budget: There are 2 groups and 3 budgets. Use one budget, or one per group.",
        ),
        (
            "hopper-gravity,hopper-motor-noise",
            "1M,100k",
            "--budget: gym_extensions/Hopper-v0 is in two groups with the budgets 1M and 100k. "
            "Use the same budget for these groups.",
        ),
        ("hopper-gravity", "2M", "There is no budget '2M'. Choose one of: 100k, 1M, 300k, paper, smoke."),
    ],
)
def test_budgets_that_do_not_match_the_groups_are_rejected(groups: str, budgets: str, message: str) -> None:
    with pytest.raises(BenchError) as error:
        cli.task_budgets(groups, budgets)
    assert str(error.value) == message


def test_rows_that_another_process_adds_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(content, "FLOOR_EPISODES", 4)
    monkeypatch.setattr(content, "CEILING_EPISODES", 3)
    other, out = tmp_path / "other" / "mine.json", tmp_path / "mine.json"
    options = ["--budget", "smoke", "--runs", "1000", "--out"]
    assert cli.main(["--groups", "pusher-tracking", *options, str(other)]) == 0

    class Meanwhile(ThisProcess):
        def run(self, pending: Any, listen: Any) -> Any:
            shutil.copyfile(other, out)
            yield from super().run(pending, listen)

    monkeypatch.setattr(content, "Workers", Meanwhile)
    assert cli.main(["--groups", "striker-tracking", *options, str(out)]) == 0
    names = ("Pusher", "PusherTrackingGoal", "Striker", "StrikerTrackingGoal")
    assert set(json.loads(out.read_text())["tasks"]) == {f"gym_extensions/{name}-v0" for name in names}
