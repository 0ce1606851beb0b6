"""The examples of the README run as printed, and what it says about groups and references is true."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.__main__ import main
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.registry import task
from gym_extensions.scoring.references import load_references

README = Path(__file__).resolve().parent.parent / "README.md"
TEXT = README.read_text("utf-8")


def test_the_python_example_runs_and_prints_the_training_order(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
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


def test_the_commands_about_environments_print_what_the_readme_says(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["envs", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sum(not line.startswith(" ") and "tasks)" in line for line in lines) == 31 + 1
    assert len({line for line in lines if line.startswith("  ")}) == 237
    assert main(["envs", "show", "HopperGravityHalf"]) == 0
    assert "-4.905" in capsys.readouterr().out


def test_the_commands_that_train_and_score_are_those_of_the_page_on_submissions() -> None:
    """They run in tests/baselines/test_submit_doc.py and tests/scoring/test_cli.py."""
    commands = re.findall(r"^gym-extensions train .*$", TEXT, flags=re.MULTILINE)
    page = (README.parent / "docs" / "submit.md").read_text("utf-8")
    assert len(commands) == 1
    assert commands[0] in page


def test_the_reproduction_on_the_first_screen_is_that_of_its_page() -> None:
    (paragraph,) = re.findall(r"With the paper's settings.*?\.\n\n", TEXT, flags=re.DOTALL)
    page = (README.parent / "docs" / "reproduction.md").read_text("utf-8")
    hopper_printed, hopper, cheetah_printed, cheetah = re.findall(
        r"earlier tasks end lower, (\d+) % kept", page
    )
    assert re.findall(r"(\d+) %", paragraph) == [hopper, cheetah, hopper_printed, cheetah_printed]


def test_every_task_has_references() -> None:
    references = load_references()
    assert "Every task has references." in TEXT
    assert [row.name for row in GROUPS.values() if references.missing(row.task_ids)] == []


def test_the_unsolved_tasks_are_those_of_the_references() -> None:
    unsolved = [task_id for task_id, reference in load_references().tasks.items() if reference.unsolved]
    assert names_in(r"300k steps the reference agent does not learn\s+(.*?)\.") == sorted(
        task(task_id).name for task_id in unsolved
    )


def names_in(sentence: str) -> list[str]:
    """The names in backticks in the README's sentence, sorted."""
    (matched,) = re.findall(sentence, TEXT, flags=re.DOTALL)
    return sorted(re.findall(r"`([A-Za-z0-9-]+)`", matched))
