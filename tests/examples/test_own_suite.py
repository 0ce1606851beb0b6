"""examples/own_suite.py: trained, scored with its own references, and plotted."""

import runpy
from pathlib import Path

import pandas as pd
import pytest

from gym_extensions import results
from gym_extensions.envs import TaskGroup, load_group

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, TaskGroup, pd.DataFrame]:
    """The folder that the example wrote, its suite, and its scores."""
    pytest.importorskip("matplotlib", reason="the plot needs matplotlib: the extra `plot`")
    folder = tmp_path_factory.mktemp("suite")
    (folder / "examples").mkdir()
    references = (EXAMPLES / "own_suite.json").read_text(encoding="utf-8")
    (folder / "examples/own_suite.json").write_text(references, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MPLBACKEND", "Agg")
        patch.chdir(folder)
        names = runpy.run_path(str(EXAMPLES / "own_suite.py"), run_name="__main__")
    return folder / "trained", names["suite"], names["scores"]


def test_the_suite_is_trained_scored_with_its_references_and_plotted(
    example: tuple[Path, TaskGroup, pd.DataFrame],
) -> None:
    trained, suite, scores = example
    assert load_group(EXAMPLES / "own_suite.toml") == suite
    episodes = results.episodes(trained / "own", groups=[suite])
    assert episodes.groupby(["run", "stage", "task"]).size().eq(20).sum() == 4 * 3
    assert scores[scores["metric"] == "final_performance"]["mean"].between(-1, 1).tolist() == [True]
    assert (trained / "own.png").read_bytes().startswith(b"\x89PNG")
