"""``gym-extensions envs``: output and exit status."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from gym_extensions.catalog import fingerprints
from gym_extensions.envs import cli, fingerprint


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


def test_check_succeeds_when_tasks_match(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", "HopperGravityHalf", "Hopper"]) == 0
    assert capsys.readouterr().out == "2 tasks match their published fingerprints.\n"


def test_check_fails_when_a_value_differs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    table = {**fingerprints.table(), "engine": fingerprint.engine() | {"gymnasium": "1.0.0"}}
    monkeypatch.setattr(fingerprints, "table", lambda: table)
    assert cli.main(["check", "Hopper"]) == 1
    assert capsys.readouterr().err.splitlines() == [
        "engine: gymnasium is '1.4.0', published as '1.0.0'",
        "1 difference in 1 of 1 task.",
        "A task that changes needs a new version number.",
    ]


def test_an_unknown_name_prints_an_error_without_a_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["show", "HopperGravtyHalf"]) == 2
    message = "error: There is no task 'HopperGravtyHalf'. Did you mean 'HopperGravityHalf'?\n"
    assert capsys.readouterr().err == message


def test_show_prints_the_fingerprint(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["show", "HopperGravityHalf"]) == 0
    assert fingerprints.published("gym_extensions/HopperGravityHalf-v0") in capsys.readouterr().out


def test_the_help_is_plain_text_and_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(["-h"])
    text = capsys.readouterr().out
    assert stopped.value.code == 0
    assert "`" not in text
    assert all(f"\n    {name}" in text for name in ("list", "show", "check", "fingerprint", "docs"))


def test_output_that_nobody_reads_is_discarded() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "gym_extensions", "envs", "list"]
    process = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False)
    os.close(writer)
    assert (process.returncode, process.stderr) == (1, b"")
