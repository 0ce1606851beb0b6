"""Logs, curves and evaluations as data frames: every row of the files, with documented columns and types."""

import csv
from pathlib import Path

import msgspec
import pandas as pd
import pytest

from gym_extensions import results
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.submissions.run import InterimEvaluation, read_run, write_run

from ..conftest import Write, refused

GROUP = "hopper-gravity"
IDS = group(GROUP).task_ids


def rows_of(folder: Path, protocol: str) -> list[dict[str, str]]:
    rows = []
    for path in sorted((folder / GROUP / protocol).glob("*.csv")):
        run = path.stem.removeprefix("run")
        with path.open(newline="", encoding="utf-8") as lines:
            rows += [{"run": run, **row} for row in csv.DictReader(lines)]
    return rows


def with_evaluations(folder: Path) -> Path:
    """The submission with an evaluation of every task in the second stage of run 0."""
    path = folder / GROUP / "sequential" / "run0.json"
    facts = {"stage": 2, "episodes": 5, "steps": [250]}
    parts = [InterimEvaluation(task=task, returns=[70.0 + at], **facts) for at, task in enumerate(IDS)]  # type: ignore[arg-type]
    write_run(path, msgspec.structs.replace(read_run(path), evaluations=parts))
    return folder


def test_every_logged_episode_is_a_row(make_submission: Write) -> None:
    folder = make_submission()
    frame = results.episodes(folder)
    expected = rows_of(folder, "sequential") + rows_of(folder, "single")
    assert len(frame) == len(expected) == 2 * (6 * 5 * 20) + 2 * 5 * 20
    for column in ("run", "stage", "episode", "seed", "length", "return"):
        assert frame[column].tolist() == [float(row[column]) for row in expected]
    assert frame["task"].tolist() == [row["task"] for row in expected]
    assert frame["fingerprint"].tolist() == [published(row["task"]) for row in expected]
    assert frame["success"].isna().all()
    assert set(frame["submission"]) == {"submission"}
    assert set(frame["group"]) == {"hopper-gravity-v0"}


def test_runs_after_a_missing_one_are_in_no_frame(make_submission: Write) -> None:
    submission = make_submission(runs=(0, 1, 3), protocols=("sequential",), curves=2)
    for function in (results.episodes, results.curves, results.evaluations, results.policies):
        assert set(function(submission)["run"]) == {0, 1}


def test_episodes_come_back_from_parquet(make_submission: Write, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    frame = results.episodes(make_submission(protocols=("single",)))
    frame.to_parquet(tmp_path / "episodes.parquet")
    assert pd.read_parquet(tmp_path / "episodes.parquet").equals(frame)


def test_success_is_missing_only_where_the_task_defines_none(make_submission: Write) -> None:
    frame = results.episodes(make_submission(groups=("humanoid-standup-run",), protocols=("single",)))
    assert frame["success"].dtype == "boolean"
    defined = frame["success"].notna().groupby(frame["task"], sort=False).agg(["min", "max"])
    assert defined.to_numpy().tolist() == [[False, False], [True, True], [True, True]]
    assert frame["success"].sum() == 0


def test_every_point_of_the_curves_is_a_row(make_submission: Write) -> None:
    folder = make_submission(curves=12)
    frame = results.curves(folder)
    documents = [read_run(path) for path in sorted(folder.glob(f"{GROUP}/*/run*.json"))]
    expected = [(document, curve) for document in documents for curve in document.curves]
    assert frame["step"].tolist() == [step for _, curve in expected for step in curve.steps]
    assert frame["return"].tolist() == [value for _, curve in expected for value in curve.returns]
    keys = [(each.protocol, each.run, curve.task) for each, curve in expected for _ in curve.steps]
    assert [*zip(frame["protocol"], frame["run"], frame["task"], strict=True)] == keys


def test_several_submissions_are_one_frame(make_submission: Write) -> None:
    folders = [make_submission(name=name) for name in ("first", "second")]
    assert results.episodes(folders)["submission"].unique().tolist() == ["first", "second"]
    assert results.episodes(folders[0].parent).equals(results.episodes(folders))


def test_a_submission_without_curves_gives_an_empty_frame_with_the_same_types(make_submission: Write) -> None:
    filled = results.curves(make_submission(name="a", curves=12))
    empty = results.curves(make_submission(name="b"))
    assert (len(empty), empty.dtypes.equals(filled.dtypes)) == (0, True)


def test_a_submission_with_problems_is_refused(make_submission: Write) -> None:
    folder = make_submission()
    log = folder / GROUP / "sequential" / "run0.csv"
    log.write_text(log.read_text().replace(",false,", ",maybe,", 1), newline="\n")
    with refused("not-valid", f"Run: score {folder}"):
        results.episodes(folder)


def test_evaluations_during_training_lie_between_those_after_the_stages(make_submission: Write) -> None:
    frame = results.evaluations(with_evaluations(make_submission(runs=(0,), protocols=("sequential",))))
    first = frame[frame["task"] == IDS[0]]
    assert first["trained"].tolist() == [0, 1, 1.25, 2, 3, 4, 5]
    assert first["step"].tolist() == [0, 1000, 250, *[1000] * 4]
    assert first["episodes"].tolist() == [20, 20, 5, *[20] * 4]
    # The formula of the submission: 100 per stage, 10 for the first task, and episodes from 0 to 19/8.
    means = [100.0 * stage + 10 + 9.5 / 8 for stage in range(6)]
    assert first["return"].tolist() == [*means[:2], 70.0, *means[2:]]
    assert frame["task"].tolist() == [*IDS] * 7
