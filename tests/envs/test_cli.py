"""``gym-extensions envs``: output and exit status."""

import os
import subprocess
import sys
from importlib.metadata import version
from typing import Any

import pytest

from gym_extensions.catalog.descriptions import summary
from gym_extensions.catalog.groups import groups_named
from gym_extensions.catalog.tasks import task
from gym_extensions.envs import cli, fingerprinting


def test_list_prints_the_tasks_of_a_group_in_training_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["list", "hopper-gravity"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "hopper-gravity-v0 (5 tasks)",
        "  gym_extensions/HopperGravityHalf-v0",
        "  gym_extensions/HopperGravityThreeQuarters-v0",
        "  gym_extensions/Hopper-v0",
        "  gym_extensions/HopperGravityOneAndQuarter-v0",
        "  gym_extensions/HopperGravityOneAndHalf-v0",
    ]


def test_list_takes_the_word_core_as_train_and_score_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["list", "core"]) == 0
    titles = [line for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert titles == [f"{each.id} ({len(each.tasks)} tasks)" for each in groups_named("core")]


def test_show_prints_the_summary(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["show", "StrikerMovingStart"]) == 0
    text = capsys.readouterr().out
    assert text == summary(task("StrikerMovingStart")) + "\n"
    for fact in ("100 steps", "striker-v0", "x ~ U(0.43, 0.55)", "motor of r_wrist_roll_joint", "-3 … 3"):
        assert fact in text
    assert "smallest distance between ball and goal" in text
    assert "22     z of the goal" in text


def test_check_succeeds_when_tasks_match(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", "HopperGravityHalf", "Hopper"]) == 0
    assert capsys.readouterr().out == "2 tasks match their published fingerprints.\n"


def test_check_finds_a_difference(table: Any, capsys: pytest.CaptureFixture[str]) -> None:
    table["engine"]["gymnasium"] = "1.0.0"
    assert cli.main(["check", "Hopper"]) == 0, "another engine is named, and is no difference of a task"
    assert "gymnasium 1.4.0" in capsys.readouterr().err
    table["tasks"]["gym_extensions/Hopper-v0"]["definition"]["max_steps"] = 999
    assert cli.main(["check", "Hopper"]) == 1
    assert "definition.max_steps is 1000, published as 999" in capsys.readouterr().err


def test_check_prints_a_line_per_task_and_all_differences_of_a_task_that_is_named(
    table: Any, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("gym_extensions/Hopper-v0", "gym_extensions/Pusher-v0")
    table["tasks"] = {name: table["tasks"][name] for name in names}
    for row in table["tasks"].values():
        row["canary"]["episodes"][0]["rewards"] = [9.0] * 8
    for module in (cli, fingerprinting):
        monkeypatch.setattr(module, "TASKS", {name: task(name) for name in names})
    assert cli.main(["check"]) == 1
    *differences, summed = capsys.readouterr().err.splitlines()
    assert [line.partition(":")[0] for line in differences] == list(names)
    assert summed.startswith("2 of 2 tasks differ, in 18 values.") and "new version" in summed
    assert cli.main(["check", "Pusher"]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 9 + 1


def test_tasks_that_differ_with_another_engine_are_mended_by_the_published_one(
    table: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    table["engine"]["mujoco"] = "9.0.0"
    table["tasks"]["gym_extensions/Hopper-v0"]["definition"]["max_steps"] = 999
    assert cli.main(["check", "Hopper"]) == 1
    first, *_, last = capsys.readouterr().err.splitlines()
    assert f"mujoco {version('mujoco')} (not 9.0.0)" in first
    assert "score refuses them" in last and "pip install mujoco==9.0.0" in last and "new version" not in last


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["show", "HopperGravtyHalf"], "'HopperGravityHalf'"),
        (["show", "Pendulum-v1"], "envs list names them"),
        (["list", "mine"], "envs list names them"),
    ],
)
def test_an_unknown_name_prints_an_error_without_a_traceback(
    arguments: list[str], hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(arguments) == 2
    assert hint in capsys.readouterr().err


@pytest.mark.parametrize("name", ["Pusher", "State-Based-Navigation-2d-Map0-Goal0"])
def test_characters_that_the_output_lacks_are_replaced(name: str) -> None:
    environment = os.environ | {"PYTHONUTF8": "0", "PYTHONIOENCODING": "cp1252"}
    command = [sys.executable, "-m", "gym_extensions", "envs", "show", name]
    process = subprocess.run(command, env=environment, capture_output=True, check=True)
    assert name.encode() in process.stdout and process.stderr == b""


def test_output_that_nobody_reads_is_discarded() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "gym_extensions", "envs", "list"]
    process = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False)
    os.close(writer)
    assert (process.returncode, process.stderr) == (1, b"")
