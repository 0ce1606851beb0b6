"""What an installed copy must be: a command that names its sub-commands and its version, typed packages."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCE_ROOTS = ("envs", "scoring", "baselines", "site")


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words], cwd=ROOT.parent, capture_output=True, text=True, check=False, timeout=120
    )


def test_the_command_lists_its_sub_commands_and_says_usage_is_wrong_without_one() -> None:
    shown = run("-m", "gym_extensions")
    assert shown.returncode == 2
    assert shown.stdout.startswith("usage: gym-extensions COMMAND")


def test_an_unknown_sub_command_is_told_with_the_closest_one_and_no_traceback() -> None:
    shown = run("-m", "gym_extensions", "trian")
    assert (shown.returncode, shown.stderr) == (
        2,
        "error: There is no command 'trian'. Did you mean 'train'?\n",
    )


def test_the_version_is_that_of_pyproject() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert run("-m", "gym_extensions", "--version").stdout.strip() == declared


def test_every_package_is_marked_as_typed() -> None:
    packages = [
        path.parent for root in SOURCE_ROOTS for path in (ROOT / root).glob("gym_extensions/*/__init__.py")
    ]
    assert packages
    assert [path.name for path in packages if not (path / "py.typed").exists()] == []
