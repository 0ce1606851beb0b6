"""What an installed copy must be: one namespace package from four roots, a command that answers at once."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SOURCE_ROOTS = ("envs", "scoring", "baselines", "site")


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words], cwd=ROOT.parent, capture_output=True, text=True, check=False, timeout=120
    )


def test_no_root_holds_an_init_file_that_would_hide_the_other_parts() -> None:
    assert [root for root in SOURCE_ROOTS if (ROOT / root / "gym_extensions" / "__init__.py").exists()] == []


def test_the_wheel_names_each_source_root() -> None:
    hatch = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]
    assert hatch["dev-mode-dirs"] == list(SOURCE_ROOTS)
    assert hatch["targets"]["wheel"]["sources"] == list(SOURCE_ROOTS)
    assert hatch["targets"]["wheel"]["only-include"] == [f"{root}/gym_extensions" for root in SOURCE_ROOTS]


@pytest.mark.parametrize("module", ["gym_extensions.scoring.cli", "gym_extensions.site.cli"])
def test_scoring_and_site_load_no_simulator_and_no_torch(module: str) -> None:
    heavy = "{'mujoco', 'gymnasium', 'torch', 'stable_baselines3'}"
    code = f"import sys, {module}; print(sorted({heavy} & set(sys.modules)))"
    assert run("-c", code).stdout == "[]\n"


def test_building_the_site_loads_no_simulator_and_no_torch(tmp_path: Path) -> None:
    for name in ("trpo-2017-paper", "henderson2017-trpo"):  # with runs, and a printed table
        shutil.copytree(ROOT / "submissions" / name, tmp_path / "submissions" / name)
    code = (
        "import sys; from gym_extensions.__main__ import main;"
        f"main(['site', {str(tmp_path / 'submissions')!r}, '--out', {str(tmp_path / 'pages')!r}]);"
        "print(sorted({'mujoco', 'gymnasium', 'torch'} & set(sys.modules)), file=sys.stderr)"
    )
    assert run("-c", code).stderr.splitlines()[-1] == "[]"


def test_the_command_lists_its_sub_commands_and_says_usage_is_wrong_without_one() -> None:
    shown = run("-m", "gym_extensions")
    assert shown.returncode == 2
    assert shown.stdout.startswith("usage: gym-extensions COMMAND")


def test_an_unknown_sub_command_is_told_with_the_closest_one_and_no_traceback() -> None:
    shown = run("-m", "gym_extensions", "trian")
    assert (shown.returncode, shown.stderr) == (
        2,
        "error: Unknown command 'trian'. Did you mean 'train'?\n",
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
