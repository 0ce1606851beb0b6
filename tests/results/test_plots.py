"""Plots draw the numbers of the frames: of a committed submission, and of evaluations during training."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from gym_extensions import results
from gym_extensions.errors import BenchError

from ..conftest import Write
from .test_frames import IDS, with_evaluations

matplotlib = pytest.importorskip("matplotlib")
pyplot = pytest.importorskip("matplotlib.pyplot")
SUBMISSION = Path(__file__).resolve().parents[2] / "submissions" / "trpo-2017"
GROUP = "hopper-gravity-v0"
FORGETTING = pd.DataFrame(columns=["forgetting_low"])
NAMES = ["HopperGravityHalf", "HopperGravityThreeQuarters", "Hopper", "HopperGravityOneAndQuarter"]


@pytest.fixture(autouse=True)
def no_screen() -> Iterator[None]:
    matplotlib.use("Agg")
    yield
    pyplot.close("all")


@pytest.fixture(scope="module")
def submission() -> pd.DataFrame:
    return results.evaluations(SUBMISSION)


def points(line: Any) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in zip(*line.get_data(), strict=True)]


@pytest.mark.committed
def test_curves_are_a_line_per_run_in_the_color_of_the_task() -> None:
    frame = results.curves(SUBMISSION)
    axes = results.plot_curves(frame, "hopper-gravity", protocol="single")
    rows = frame[(frame["group"] == GROUP) & (frame["protocol"] == "single")]
    lines = [[*zip(rows["step"], rows["return"], strict=True)] for _, rows in rows.groupby(["task", "run"])]
    assert sorted(points(line) for line in axes.lines) == sorted(lines)
    assert len({line.get_color() for line in axes.lines}) == 5
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()][:4] == NAMES


@pytest.mark.committed
def test_the_matrix_is_the_mean_return_by_stage_and_task(submission: pd.DataFrame) -> None:
    axes = results.plot_matrix(submission, GROUP)
    (image,) = axes.images
    rows = submission.query("group == @GROUP and protocol == 'sequential'")
    expected = rows.groupby(["stage", "task"])["return"].mean()
    drawn: Any = image.get_array()
    assert drawn.shape == (6, 5)
    assert np.allclose(drawn, expected.unstack("task")[rows["task"].unique()].to_numpy())
    assert [label.get_text() for label in axes.get_xticklabels()][:4] == NAMES


@pytest.mark.committed
def test_retention_is_a_line_per_task_over_the_trained_tasks(submission: pd.DataFrame) -> None:
    axes = results.plot_retention(submission, GROUP)
    rows = submission.query("group == @GROUP and protocol == 'sequential'")
    rows = rows[rows["task"] == IDS[0]]
    line = next(line for line in axes.lines if line.get_label() == NAMES[0])
    means = rows.groupby("stage")["return"].mean()
    assert [x for x, _ in points(line)] == [*range(6)]
    assert [y for _, y in points(line)] == pytest.approx(means.tolist())


def test_interim_evaluations_are_points_within_the_stages(make_submission: Write) -> None:
    folder = with_evaluations(make_submission(runs=(0, 1)))
    _, ax = pyplot.subplots()
    axes = results.plot_retention(folder, ax=ax)
    assert axes is ax
    line = next(line for line in axes.lines if line.get_label() == NAMES[0])
    assert [x for x, _ in points(line)] == [0, 1, 1.25, 2, 3, 4, 5]


@pytest.mark.committed
def test_a_board_is_a_point_per_submission_with_its_interval() -> None:
    folder = SUBMISSION.parent
    frame = results.board("halfcheetah-gravity", [folder / "trpo", folder / "reset"])
    axes = results.plot_board(frame, metric="forgetting")
    (line,) = axes.lines
    frame = frame[frame["forgetting"].notna()]
    assert points(line) == [(value, i) for i, value in enumerate(frame["forgetting"])]
    assert [label.get_text() for label in axes.get_yticklabels()] == frame["name"].tolist()
    frame = frame[frame["forgetting_low"].notna()]
    (bars,) = axes.collections
    ends = [(segment[0][0], segment[1][0]) for segment in bars.get_segments()]  # type: ignore[attr-defined]
    assert ends == [*zip(frame["forgetting_low"], frame["forgetting_high"], strict=True)]


@pytest.mark.committed
@pytest.mark.parametrize(
    ("plot", "fact"),
    [
        (results.plot_matrix, "several values of 'group'"),
        (lambda frame: results.plot_retention(frame, "pusher"), "no rows of pusher, sequential"),
        (lambda frame: results.plot_curves(frame.drop(columns="step")), "no column 'step'"),
        (results.plot_board, "no submission with a metric"),
        (lambda _: results.plot_board(SUBMISSION), "group='hopper-gravity'"),
        (lambda _: results.plot_board(FORGETTING, metric="forgeting"), "Did you mean 'forgetting'"),
    ],
)
def test_a_plot_of_unsuitable_data_is_an_error(
    plot: Callable[[pd.DataFrame], object], fact: str, submission: pd.DataFrame
) -> None:
    with pytest.raises(BenchError, match=fact):
        plot(submission)


@pytest.mark.committed
def test_a_missing_matplotlib_is_named_with_the_command_that_installs_it(
    submission: pd.DataFrame, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot", raising=False)
    with pytest.raises(BenchError, match=r"matplotlib.*plot"):
        results.plot_matrix(submission, GROUP)
