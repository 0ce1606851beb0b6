"""``gym-extensions envs``: what it prints and how it exits."""

from __future__ import annotations

import pytest

from gym_extensions.catalog import fingerprints
from gym_extensions.envs import cli, fingerprint


def test_list_names_a_groups_tasks_in_training_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["list", "hopper-gravity"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "hopper-gravity-v0 (5 tasks)",
        "  gym_extensions/HopperGravityHalf-v0",
        "  gym_extensions/HopperGravityThreeQuarters-v0",
        "  gym_extensions/Hopper-v0",
        "  gym_extensions/HopperGravityOneAndQuarter-v0",
        "  gym_extensions/HopperGravityOneAndHalf-v0",
    ]


def test_check_says_that_tasks_are_as_published(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", "HopperGravityHalf", "Hopper"]) == 0
    assert capsys.readouterr().out == "2 tasks are as published.\n"


def test_check_fails_when_a_number_moved(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    table = {**fingerprints.table(), "engine": fingerprint.engine() | {"gymnasium": "1.0.0"}}
    monkeypatch.setattr(fingerprints, "table", lambda: table)
    assert cli.main(["check", "Hopper"]) == 1
    assert capsys.readouterr().err.splitlines() == [
        "engine: gymnasium is '1.4.0', published as '1.0.0'",
        "1 differences in 1 of 1 tasks.",
        "A task that changes needs a new version number.",
    ]


def test_an_unknown_name_is_told_without_a_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["show", "HopperGravtyHalf"]) == 2
    told = "error: There is no task 'HopperGravtyHalf'. Did you mean 'HopperGravityHalf'?\n"
    assert capsys.readouterr().err == told


def test_show_prints_the_fingerprint(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["show", "HopperGravityHalf"]) == 0
    assert fingerprints.published("gym_extensions/HopperGravityHalf-v0") in capsys.readouterr().out
