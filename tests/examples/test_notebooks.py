"""The notebooks run from top to bottom, as plain Python, and keep no output."""

import contextlib
import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.ipynb"))
QUICK = {
    '"hopper-gravity"': '"hopper-motor-noise"',
    "baselines import train": "baselines import Parallel, train",
    "out=out": "out=out, parallel=Parallel(num_envs=5)",
}
"""What saves time in the tests: two tasks in place of five, and environments that are stepped together."""


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_a_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    cells = json.loads(path.read_text("utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and not any(cell["outputs"] for cell in code)
    text = "\n\n".join("".join(cell["source"]) for cell in code)
    for whole, quick in QUICK.items():
        text = text.replace(whole, quick)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with contextlib.chdir(tmp_path):
        exec(text, {"__name__": "__main__"})
    pyplot.close("all")
