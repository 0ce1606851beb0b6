"""Logs as data frames: every row of the files, with documented columns and types."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions import results
from gym_extensions.errors import BenchError

Write = Callable[..., Path]
GROUP = "hopper-gravity"


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def test_every_logged_episode_is_a_row(submission: Write) -> None:
    folder = submission()
    frame = results.episodes(folder)
    expected = rows_of(folder / GROUP / "sequential.csv") + rows_of(folder / GROUP / "single.csv")
    assert len(frame) == len(expected) == 2 * (6 * 5 * 20) + 2 * 5 * 20
    for column in ("run", "stage", "episode", "seed", "length", "return"):
        assert frame[column].tolist() == [float(row[column]) for row in expected]
    for column in ("task", "fingerprint"):
        assert frame[column].tolist() == [row[column] for row in expected]
    assert frame["success"].isna().all()
    assert set(frame["submission"]) == {"entry"}
    assert set(frame["group"]) == {"hopper-gravity-v0"}


def test_success_is_missing_only_where_the_task_defines_none(submission: Write) -> None:
    frame = results.episodes(submission(groups=("humanoid-standup-run",), protocols=("single",)))
    assert frame["success"].dtype == "boolean"
    defined = frame["success"].notna().groupby(frame["task"], sort=False).agg(["min", "max"])
    assert defined.to_numpy().tolist() == [[False, False], [True, True], [True, True]]
    assert frame["success"].sum() == 0


def test_every_point_of_the_curves_is_a_row(submission: Write) -> None:
    folder = submission(curves=12)
    frame = results.curves(folder)
    expected = rows_of(folder / GROUP / "curves.csv")
    assert frame["step"].tolist() == [int(row["step"]) for row in expected]
    assert frame["return"].tolist() == [float(row["return"]) for row in expected]
    assert frame["protocol"].tolist() == [row["protocol"] for row in expected]


def test_several_submissions_are_one_frame(submission: Write) -> None:
    folders = [submission(name=name) for name in ("first", "second")]
    assert results.episodes(folders)["submission"].unique().tolist() == ["first", "second"]
    assert results.episodes(folders[0].parent).equals(results.episodes(folders))


def test_a_submission_without_curves_gives_an_empty_frame_with_the_same_types(submission: Write) -> None:
    filled, empty = results.curves(submission(name="a", curves=12)), results.curves(submission(name="b"))
    assert len(empty) == 0
    assert empty.dtypes.equals(filled.dtypes)


def test_columns_can_be_chosen(submission: Write) -> None:
    assert results.episodes(submission(), columns=["return", "run"]).columns.tolist() == ["return", "run"]


def test_an_unknown_column_is_reported_with_the_closest(submission: Write) -> None:
    with pytest.raises(BenchError) as error:
        results.episodes(submission(), columns=["retrun"])
    assert str(error.value) == "columns: There is no column 'retrun'. Did you mean 'return'?"


def test_a_submission_with_problems_is_refused(submission: Write) -> None:
    folder = submission()
    log = folder / GROUP / "sequential.csv"
    log.write_text(log.read_text().replace(",false,", ",maybe,", 1), newline="\n")
    with pytest.raises(BenchError) as error:
        results.episodes(folder)
    assert error.value.hint == f"Run: score {folder}"
