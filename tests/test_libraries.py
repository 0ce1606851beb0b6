"""docs/libraries.md: every line runs with the stated version of its library, where that is installed."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gym_extensions.versions import version_or_none

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs/libraries.md").read_text(encoding="utf-8")
SECTIONS = {part.partition("\n")[0]: part for part in PAGE.split("\n## ")[1:]}
ROW = re.compile(r"^\| (\S+) \| `(\S+)` \| (\S+) \|", re.MULTILINE)
LIBRARIES = {name: (package, stated) for name, package, stated in ROW.findall(PAGE)}
"""The package and the stated version of each library. CleanRL's is a commit."""
BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)
CLONE = "CLEANRL"
"""The environment variable with a clone of CleanRL."""


def test_the_job_of_continuous_integration_installs_the_versions_of_the_page() -> None:
    job = (ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8").partition("\n  libraries:")[2]
    assert list(SECTIONS) == list(LIBRARIES)
    for package, stated in LIBRARIES.values():
        wanted = rf"ref: {stated}" if package == "cleanrl" else rf"{package}(\[\S+\])?=={re.escape(stated)}\b"
        assert re.search(wanted, job), package


@pytest.mark.parametrize("name", LIBRARIES)
def test_every_line_of_the_page_runs(name: str, tmp_path: Path) -> None:
    package, stated = LIBRARIES[name]
    folder = tmp_path / "work"
    if package == "cleanrl":
        if not (clone := os.environ.get(CLONE)):
            pytest.skip(f"{CLONE} names no clone")
        shutil.copytree(clone, folder)
    else:
        if (installed := version_or_none(package)) is None:
            pytest.skip(f"{package} is not installed")
        assert installed == stated
        folder.mkdir()
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "MINARI_DATASETS_PATH": str(tmp_path / "d")}
    blocks = BLOCK.findall(SECTIONS[name])
    assert blocks
    for language, code in blocks:
        if language == "yaml":
            (folder / "hopper.yml").write_text(code, encoding="utf-8")
            continue
        command = [sys.executable, "-c", code] if language == "python" else ["sh", "-ec", code]
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr[-3000:]
