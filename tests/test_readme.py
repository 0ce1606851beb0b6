"""The example of the README runs, with a shorter group, and its number of tasks is that of the catalog."""

import re
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import train

TEXT = (Path(__file__).resolve().parent.parent / "README.md").read_text("utf-8")


def test_the_example_runs_and_its_submission_has_no_problem(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    assert len(example.splitlines()) <= 12
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    training = 'train("trpo", "hopper-gravity"'
    assert training in example
    exec(example.replace(training, 'train("trpo", "hopper-motor-noise"'), names)
    assert names["train"] is train
    assert names["envs"].num_envs == 64
    assert names["custom"].unwrapped.model.opt.gravity[2] == pytest.approx(-9.81 * 0.8)
    assert "['HopperGravityHalf', 'HopperGravityThreeQuarters', 'Hopper'" in capsys.readouterr().out
    for name in ("env", "envs", "custom"):
        names[name].close()
    assert main(["score", "submissions/mine"]) == 0


def test_the_number_of_tasks_is_that_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["envs", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    (stated,) = re.findall(r"(\d+) versioned\s+tasks", TEXT)
    assert len({line for line in lines if line.startswith("  ")}) == int(stated)
