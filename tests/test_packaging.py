"""What an installed copy must be: a command that names its sub-commands and its version, typed packages."""

import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from .test_public_api import PUBLIC

ROOT = Path(__file__).resolve().parent.parent


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
    assert shown.returncode == 2
    assert shown.stderr == "error: There is no command 'trian'. Did you mean 'train'?\n"


def test_the_version_is_that_of_pyproject() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert run("-m", "gym_extensions", "--version").stdout.strip() == declared


@pytest.mark.slow
@pytest.mark.parametrize("installed", ["development mode", "wheel"])
def test_a_users_agent_that_imports_every_public_module_passes_mypy(installed: str, tmp_path: Path) -> None:
    names = [(module, name) for module, names in PUBLIC.items() for name in names.split()]
    imports = [f"from {module} import {name} as name{i}" for i, (module, name) in enumerate(names)]
    (tmp_path / "agent.py").write_text("\n".join([*imports, AGENT]))
    python = sys.executable
    if installed == "wheel":
        packages = [path for path in sys.path if path.endswith("site-packages")]
        run("-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(ROOT))
        (wheel,) = tmp_path.glob("*.whl")
        run("-m", "venv", "--without-pip", str(tmp_path / "venv"))
        (own,) = (tmp_path / "venv").glob("lib/*/site-packages")
        (own / "dependencies.pth").write_text("\n".join(packages))  # of which no .pth file is read
        zipfile.ZipFile(wheel).extractall(own)
        python = str(tmp_path / "venv/bin/python")
    words = ["-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), "--python-executable", python]
    shown = subprocess.run(
        [sys.executable, *words, "agent.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert shown.stdout == "Success: no issues found in 1 source file\n"


AGENT = """
from pathlib import Path
from typing import Any
import numpy as np
from gym_extensions.baselines import Card, Context, Observes, train
from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.envs import group
from gym_extensions.errors import BenchError

class Mine:
    observes = Observes(boundaries=True)

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        self.weights = np.zeros((observation_space.shape[0], action_space.shape[0]))

    def act(self, observations: Array, context: Context) -> Array:
        return observations @ self.weights

    def learn(self, env: VectorEnv, steps: int) -> None:
        env.reset()

    def save(self, path: Path) -> None:
        np.savez(path, weights=self.weights)

    @classmethod
    def load(cls, path: Path) -> "Mine":
        return cls.__new__(cls)

    def card(self) -> Card:
        return Card("mine", parameters=self.weights.size)

try:
    logs: list[Path] = train(Mine, group("hopper-gravity"), "sequential", "smoke", range(5), out="mine")
except BenchError as error:
    print(error.hint)
"""
