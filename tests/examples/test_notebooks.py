"""The notebooks run from top to bottom, as plain Python, and keep no output."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.ipynb"))
QUICK = {
    '"hopper-gravity"': '"hopper-wall"',
    "baselines import train": "baselines import Parallel, train",
    "out=out": "out=out, parallel=Parallel(num_envs=5)",
}
"""What saves time in the tests: two tasks in place of five, and environments that are stepped together."""


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_a_notebook_runs(path: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    cells = json.loads(path.read_text("utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and not any(cell["outputs"] for cell in code)
    script = tmp_path / "notebook.py"
    text = "\n\n".join("".join(cell["source"]) for cell in code)
    for whole, quick in QUICK.items():
        text = text.replace(whole, quick)
    script.write_text(text, "utf-8")
    environment = os.environ | {"MPLBACKEND": "agg"}
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
