"""Compiled code is cached on disk and recompiled when a source file changes."""

import shutil
import subprocess
import sys
from pathlib import Path

from gym_extensions.envs.navigation import geometry as compiled

HERE = Path(compiled.__file__).parent
CODE = """
import numpy as np
from gym_extensions.envs.navigation.geometry import parse
from gym_extensions.envs.navigation.sensors import find_nearest
solids, seen = parse(["###", "#.#", "###"]).solid[None], np.zeros((1, 4), np.float32)
find_nearest(solids, np.zeros(1, int), np.array([[14.0, 15.0]]), seen)
print(seen[0, 2])
print(sum(find_nearest.stats.cache_hits.values()), sum(find_nearest.stats.cache_misses.values()))
"""


def run(root: Path) -> list[str]:
    """What the code prints when the packages below ``root`` come first."""
    # A bare package in place of gym_extensions.envs, whose import would load much that is not needed here.
    script = (
        "import sys, types\n"
        "sys.modules['gym_extensions.envs'] = package = types.ModuleType('gym_extensions.envs')\n"
        f"package.__path__ = [{str(root)!r}]\n"
    ) + CODE
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_cached_code_is_reused_until_a_constant_in_another_file_changes(tmp_path: Path) -> None:
    copy = shutil.copytree(HERE, tmp_path / "navigation", ignore=shutil.ignore_patterns("__pycache__"))
    assert run(tmp_path) == ["4.0", "0", "1"]
    assert run(tmp_path) == ["4.0", "1", "0"]
    # The file of the compiled function stays as it is; the size of a cell, which it reads, does not.
    module = copy / "geometry.py"
    module.write_text(module.read_text("utf-8").replace("CELL = 10.0", "CELL = 14.0"), "utf-8")
    assert run(tmp_path) == ["0.0", "0", "1"]
