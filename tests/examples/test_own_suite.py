"""examples/own_suite.py: trained, scored with its own references, and plotted."""

from __future__ import annotations

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


def test_the_log_has_every_stage_of_three_tasks(
    example: tuple[Path, TaskGroup, pd.DataFrame],
) -> None:
    trained, suite, _ = example
    assert len(suite.tasks) == 3
    episodes = results.episodes(trained / "own", groups=[suite])
    assert episodes.groupby(["run", "stage", "task"]).size().eq(20).sum() == 4 * 3


def test_the_scores_are_normalized_by_the_references(example: tuple[Path, TaskGroup, pd.DataFrame]) -> None:
    scores = example[2]
    assert scores[scores["metric"] == "final_performance"]["mean"].between(-1, 1).tolist() == [True]


def test_the_plot_is_an_image(example: tuple[Path, TaskGroup, pd.DataFrame]) -> None:
    assert (example[0] / "own.png").read_bytes().startswith(b"\x89PNG")


def test_the_file_of_the_references_defines_the_same_suite(
    example: tuple[Path, TaskGroup, pd.DataFrame],
) -> None:
    assert load_group(EXAMPLES / "own_suite.toml") == example[1]
