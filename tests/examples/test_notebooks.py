"""The notebooks run from top to bottom, as plain Python, and keep no output."""

import contextlib
import json
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))
READ_SUBMISSIONS = ("policies.ipynb",)
QUICK = {
    '"../submissions"': repr(str(ROOT / "submissions")),
    "policies(submissions)": 'policies([submissions / name for name in ("ppo-reset-tuned", "trpo", "sac")])',
    '"hopper-gravity"': '"hopper-motor-noise"',
    "baselines import train": "baselines import Parallel, train",
    "out=out": "out=out, jobs=Parallel(num_envs=5)",
}
"""What saves time in the tests: two tasks, environments that are stepped together, three submissions."""


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.committed if path.name in READ_SUBMISSIONS else (), id=path.name)
        for path in NOTEBOOKS
    ],
)
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
