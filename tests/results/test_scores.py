"""Scores as data frames: the numbers of the scorecards and boards, with documented columns and types."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from pandas.testing import assert_frame_equal

from gym_extensions import results
from gym_extensions.catalog.groups import CORE, CORES, SUITES
from gym_extensions.errors import BenchError
from gym_extensions.metrics.formulas import BOARD_METRICS, METRICS
from gym_extensions.references import References
from gym_extensions.scoring.pipeline import find_submissions, make_scorer, score_folder, scorecards
from gym_extensions.scoring.ranking.boards import BoardKey
from gym_extensions.scoring.ranking.group_board import board
from gym_extensions.submissions.review import Decision, Review, write_review

from ..conftest import GRAVITY, Write, refused

ROOT = Path(__file__).resolve().parents[2]
SUBMISSIONS = ROOT / "submissions"
pytestmark = pytest.mark.usefixtures("known")


def names(frame: pd.DataFrame) -> list[str]:
    """The submissions of a board but those computed from the references."""
    return [name for name in frame["name"] if name not in ("random", "zero")]


def number(value: float) -> float | None:
    return None if pd.isna(value) else float(value)


def test_every_metric_of_the_scorecard_is_a_row(make_submission: Write) -> None:
    folder = make_submission(runs=(0, 1, 2))
    frame = results.metrics(folder)
    card = score_folder(folder)
    rows = [
        (group, protocol, metric.name, score.metrics[metric.name])
        for group, protocols in card.groups.items()
        for protocol, score in protocols.items()
        for metric in METRICS[protocol]
    ]
    assert len(frame) == len(rows) == len(METRICS["sequential"]) + 1
    keys = [*zip(frame["group"], frame["protocol"], frame["metric"], strict=True)]
    assert keys == [(group, protocol, metric) for group, protocol, metric, _ in rows]
    for end in ("mean", "low", "high"):
        assert [*map(number, frame[end])] == [getattr(value, end) for *_, value in rows]
    assert frame["why"].tolist() == [value.why for *_, value in rows]
    for column, value in {"name": "submission", "level": "claimed", "budget": "smoke", "runs": 3}.items():
        assert set(frame[column]) == {value}


def test_a_suite_has_rows_without_a_number_of_runs(make_submission: Write) -> None:
    folder = make_submission(groups=GRAVITY, protocols=("single",))
    frame = results.metrics(folder).set_index("group")
    assert frame.index.tolist() == [*SUITES["gravity"], "gravity"]
    assert frame["runs"].isna().tolist() == [group == "gravity" for group in frame.index]
    means = frame["mean"]
    assert means["gravity"] == pytest.approx(means.drop("gravity").mean())


@pytest.mark.committed
def test_a_board_has_the_ranks_and_intervals_of_the_published_one() -> None:
    paths = [SUBMISSIONS / name for name in ("trpo", "reset")]
    frame = results.board("halfcheetah-gravity", paths)
    cards = scorecards(find_submissions(paths), make_scorer(only=["halfcheetah-gravity"]))
    published = board(list(cards), BoardKey("halfcheetah-gravity-v0", "sequential", "300k", False))
    frame = frame[frame["runs"] > 0]
    assert frame["name"].tolist() == [submission.name for submission in published.rows]
    assert frame["ranked"].tolist() == [submission.ranked for submission in published.rows]
    assert frame["why"].tolist() == [submission.why for submission in published.rows]
    assert set(frame["evaluation"]) == {"deterministic"}
    ranks = [submission.metrics["final_performance"].rank or (None, None) for submission in published.rows]
    for column, ends in zip(("rank_first", "rank_last"), zip(*ranks, strict=True), strict=True):
        assert [*map(number, frame[column])] == [*ends]
    for metric in BOARD_METRICS["sequential"]:
        for column, end in {"": "mean", "_low": "low", "_high": "high"}.items():
            expected = [getattr(submission.metrics[metric.name], end) for submission in published.rows]
            assert [*map(number, frame[f"{metric.name}{column}"])] == expected


@pytest.mark.committed
def test_a_suite_has_a_board(make_submission: Write) -> None:
    frame = results.board("gravity", SUBMISSIONS / "trpo-2017", protocol="single", budget="100k")
    assert names(frame) == ["trpo-2017"]
    assert results.board("gravity", make_submission(), budget="smoke").empty


def test_an_empty_board_has_the_same_types(make_submission: Write) -> None:
    folder = make_submission()
    filled = results.board("hopper-gravity", folder, budget="smoke")
    with pytest.warns(UserWarning, match=r"budget 100k is empty\. The submissions have the budget smoke\."):
        empty = results.board("hopper-gravity", folder, budget="100k")
    assert (len(names(filled)), len(empty)) == (1, 0)
    assert empty.dtypes.equals(filled.dtypes)


@pytest.mark.committed
@pytest.mark.parametrize(
    ("argument", "name", "closest"),
    [
        ("group", "hoper-gravity", "'hopper-gravity'"),
        ("group", "gravty", "'gravity'"),
        ("protocol", "singel", "'single'"),
        ("budget", "1m0", "'1M'"),
    ],
)
def test_an_unknown_name_is_reported_with_the_closest(argument: str, name: str, closest: str) -> None:
    with refused(f"unknown-{argument}", closest, where=argument):
        results.board(**{"group": "hopper-gravity", "submissions": SUBMISSIONS, argument: name})  # type: ignore[arg-type]


@pytest.mark.parametrize("function", [results.episodes, results.curves, results.metrics])
def test_a_path_that_does_not_exist_is_reported(function: Callable[[str], pd.DataFrame]) -> None:
    with refused("no-such-folder", where="nowhere"):
        function("nowhere")


def test_a_board_reads_only_its_groups(make_submission: Write) -> None:
    folder = make_submission(groups=("hopper-gravity", "hopper-wall"))
    (folder / "hopper-wall" / "sequential" / "run0.csv").write_text("damaged")
    assert names(results.board("hopper-gravity", folder, budget="smoke")) == ["submission"]
    assert len(results.scores(folder, "hopper-gravity")) == 2 * 6 * 5
    with refused("not-valid", "problem"):
        results.board("hopper-wall", folder, budget="smoke")


def test_scores_are_the_mean_returns_by_run_stage_and_task(
    make_submission: Write, references: References
) -> None:
    frame = results.scores(make_submission(), "hopper-gravity")
    episodes = results.episodes(make_submission())
    keys = ["run", "stage", "task"]
    means = episodes[episodes["protocol"] == "sequential"].groupby(keys)["return"].mean()
    assert frame.set_index(keys)["return"].to_dict() == pytest.approx(means.to_dict())
    both = zip(frame["task"], frame["return"], strict=True)
    assert frame["normalized"].tolist() == [references.tasks[task].normalize(value) for task, value in both]
    last = results.scores(make_submission(), "hopper-gravity-v0", stage=-1)
    assert set(last["stage"]) == {5}


@pytest.mark.committed
def test_scores_of_a_suite_name_its_groups() -> None:
    with refused("not-a-group", "'gravity' is a suite", "hopper-gravity-v0", where="group"):
        results.scores(SUBMISSIONS, "gravity")


def test_a_matrix_of_several_groups_has_their_tasks_in_order_and_the_runs_of_all(
    make_submission: Write,
) -> None:
    names = ("walker2d-gravity", "hopper-gravity")
    folder = make_submission(groups=names, runs=(0, 1, 2))
    for file in (folder / "hopper-gravity" / "sequential").glob("run2.*"):
        file.unlink()
    walker, hopper = (results.score_matrix(folder, name) for name in names)
    matrix = results.score_matrix(folder, names)
    assert [*matrix.columns] == [*walker.columns, *hopper.columns]
    assert (walker.index.tolist(), matrix.index.tolist()) == ([0, 1, 2], [0, 1])
    assert_frame_equal(matrix[hopper.columns], hopper)


def test_a_matrix_of_the_core_or_a_suite_has_the_tasks_of_its_groups(
    make_submission: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("walker2d-gravity", "hopper-gravity")
    folder = make_submission(groups=names, protocols=("sequential",))
    for table, key, name in ((CORES, CORE, "core"), (SUITES, "wall", "wall")):
        monkeypatch.setitem(table, key, names)
        assert_frame_equal(results.score_matrix(folder, name), results.score_matrix(folder, names))


def test_a_matrix_is_of_one_submission_that_has_every_group(make_submission: Write) -> None:
    first = make_submission(name="first", groups=("walker2d-gravity",))
    make_submission(name="second", groups=("hopper-gravity",))
    for path in (first, first.parent):  # the second path has each group once, but of two submissions
        with pytest.raises(BenchError, match=r"walker2d-gravity: first; hopper-gravity: (none|second)"):
            results.score_matrix(path, ["walker2d-gravity", "hopper-gravity"])


@pytest.mark.committed
def test_landscapes_are_shares_of_the_best_of_the_given_submissions() -> None:
    submissions = [ROOT / "submissions" / name for name in ("sac", "trpo")]
    both = results.landscapes(submissions)
    assert set(both["share"]) == {"interpolation", "extrapolation"}
    assert not both.duplicated(["submission", "group", "share"]).any()
    assert ((both["low"] < both["mean"]) & (both["mean"] < both["high"]) & (both["runs"] == 5)).all()
    alone = results.landscapes(submissions[0]).set_index(["group", "share"])["mean"]
    beside = both[both["submission"] == "sac"].set_index(["group", "share"])["mean"]
    assert (alone >= beside).all()  # another submission can only raise the best
    assert (alone > beside).any()
    assert results.landscapes(ROOT / "submissions" / "trpo-2017").empty  # it has no policies


@pytest.mark.committed
def test_landscapes_leave_out_withdrawn_submissions(tmp_path: Path) -> None:
    for name in ("sac", "trpo"):
        shutil.copytree(SUBMISSIONS / name / "landscapes", tmp_path / name / "landscapes")
        for file in (SUBMISSIONS / name).rglob("run*.json"):
            (copy := tmp_path / file.relative_to(SUBMISSIONS)).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
        shutil.copy(SUBMISSIONS / name / "submission.toml", tmp_path / name)
    decision = Decision(action="withdrawn", by="M.", date="2026-01-02", reason="An error.")
    write_review(tmp_path / "trpo", Review(decisions=[decision]))
    assert_frame_equal(results.landscapes(tmp_path), results.landscapes(SUBMISSIONS / "sac"))
