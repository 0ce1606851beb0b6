"""examples/own_suite.py: trained, scored with its own references, and plotted."""

import runpy
import shutil
from pathlib import Path

import pytest

from gym_extensions import results
from gym_extensions.envs import load_group

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_suite_is_trained_scored_with_its_references_and_plotted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib", reason="the plot needs matplotlib: the extra `plot`")
    (tmp_path / "examples").mkdir()
    shutil.copy(EXAMPLES / "own_suite.json", tmp_path / "examples")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(EXAMPLES / "own_suite.py"), run_name="__main__")
    suite, scores = names["suite"], names["scores"]
    assert load_group(EXAMPLES / "own_suite.toml") == suite
    episodes = results.episodes("trained/own", groups=[suite])
    assert episodes.groupby(["run", "stage", "task"]).size().eq(20).sum() == 4 * 3
    assert scores[scores["metric"] == "final_performance"]["mean"].between(-1, 1).tolist() == [True]
    assert Path("trained/own.png").read_bytes().startswith(b"\x89PNG")
