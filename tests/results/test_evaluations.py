"""Evaluations during training and after stages as one data frame, and the curves of unfinished runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions import results
from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError

Write = Callable[..., Path]
GROUP = "hopper-gravity"
IDS = group(GROUP).task_ids
HEADER = "protocol,run,stage,task,step,episodes,return\n"


def with_evaluations(folder: Path) -> Path:
    rows = [f"sequential,0,2,{task},250,5,{70 + i}.0\n" for i, task in enumerate(IDS)]
    (folder / GROUP / "evaluations.csv").write_text(HEADER + "".join(rows), newline="\n")
    return folder


def test_evaluations_during_training_lie_between_those_after_the_stages(submission: Write) -> None:
    frame = results.evaluations(with_evaluations(submission(runs=(0,), protocols=("sequential",))))
    first = frame[frame["task"] == IDS[0]]
    assert first["trained"].tolist() == [0, 1, 1.25, 2, 3, 4, 5]
    assert first["step"].tolist() == [0, 1000, 250, *[1000] * 4]
    assert first["episodes"].tolist() == [20, 20, 5, *[20] * 4]
    # The formula of the submission: 100 per stage, 10 for the first task, and episodes from 0 to 19/8.
    means = [100.0 * stage + 10 + 9.5 / 8 for stage in range(6)]
    assert first["return"].tolist() == [*means[:2], 70.0, *means[2:]]
    assert frame["task"].tolist() == [*IDS] * 7


def test_without_the_file_the_frame_has_the_evaluations_after_the_stages(submission: Write) -> None:
    frame = results.evaluations(submission(runs=(0, 1)), columns=["protocol", "run", "stage"])
    assert len(frame) == 2 * (6 * 5) + 2 * 5
    assert frame.columns.tolist() == ["protocol", "run", "stage"]


def unfinished(folder: Path, text: str) -> Path:
    path = folder / ".progress" / GROUP / "sequential-run3" / "curve-stage1.csv"
    path.parent.mkdir(parents=True)
    path.write_text(f"protocol,run,task,step,return\n{text}", newline="\n")
    return folder


@pytest.mark.parametrize("torn", ["", "sequential,3,a,75", "sequential,3,a,7500,12.", "sequential,3"])
def test_the_last_line_of_an_unfinished_curve_may_be_incomplete(torn: str, tmp_path: Path) -> None:
    complete = "sequential,3,a,2500,12.5\nsequential,3,a,5000,13.5\n"
    frame = results.unfinished_curves(unfinished(tmp_path / "mine", complete + torn))
    assert [*zip(frame["run"], frame["step"], frame["return"], strict=True)] == [
        (3, 2500, 12.5),
        (3, 5000, 13.5),
    ]
    assert set(frame["submission"]) == {"mine"}
    assert set(frame["group"]) == {GROUP}


def test_a_curve_of_a_run_that_is_finished_in_the_meantime_has_no_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = unfinished(tmp_path / "mine", "sequential,3,a,2500,12.5\n")
    find = Path.glob

    def find_and_remove(path: Path, pattern: str) -> list[Path]:
        found = list(find(path, pattern))
        for curve in found:
            curve.unlink()
        return found

    monkeypatch.setattr(Path, "glob", find_and_remove)
    assert len(results.unfinished_curves(folder)) == 0


def test_a_folder_without_unfinished_runs_gives_an_empty_frame_of_the_same_types(submission: Write) -> None:
    folder = submission(curves=12)
    frame = results.unfinished_curves(folder)
    assert len(frame) == 0
    assert frame.dtypes.equals(results.curves(folder).dtypes)


def test_a_folder_that_does_not_exist_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match=r"The folder does not exist\. Name the folder of --out\."):
        results.unfinished_curves(tmp_path / "nothing")
