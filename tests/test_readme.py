"""The example of the README runs as printed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

README = Path(__file__).resolve().parent.parent / "README.md"


def test_the_python_example_runs_and_prints_the_training_order(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text("utf-8"), flags=re.DOTALL)
    names: dict[str, Any] = {}
    exec(example, names)
    assert names["envs"].num_envs == 64
    assert names["custom"].unwrapped.model.opt.gravity[2] == pytest.approx(-9.81 * 0.8)
    assert capsys.readouterr().out.splitlines() == [
        "gym_extensions/HopperGravityHalf-v0",
        "gym_extensions/HopperGravityThreeQuarters-v0",
        "gym_extensions/Hopper-v0",
        "gym_extensions/HopperGravityOneAndQuarter-v0",
        "gym_extensions/HopperGravityOneAndHalf-v0",
    ]
    for name in ("env", "envs", "custom"):
        names[name].close()
