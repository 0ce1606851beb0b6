"""The boards of the committed submissions, computed again from the CSV files, with pandas and scipy."""

import functools
import json
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import stats

from gym_extensions.catalog.groups import SUITES, group
from gym_extensions.scoring.output.board_frames import core_frame, core_pairs_frame
from gym_extensions.scoring.pipeline import find_submissions, make_scorer, scorecards
from gym_extensions.scoring.ranking.boards import BoardsDocument
from gym_extensions.scoring.ranking.core_board import Method, compared_pairs
from gym_extensions.scoring.ranking.group_board import boards

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.committed
REFERENCES = ROOT / "scoring" / "gym_extensions" / "references" / "2.json"
GROUPS = (
    *("hopper-gravity", "walker2d-gravity", "halfcheetah-gravity"),
    *("hopper-wall", "walker2d-wall", "halfcheetah-wall", "hopper-body"),
)
LEVELS = {5: 0.005, 10: 0.01, 20: 0.01, 40: 0.01, 80: 0.01}
"""Of a family at the look at this number of runs (docs/metrics.md)."""
Runs = list[NDArray[np.float64]]
"""By group, one value per run, or (runs, tasks)."""


@pytest.fixture(scope="module")
def document() -> BoardsDocument:
    """boards.json of the committed submissions."""
    scorer = make_scorer()
    return boards(list(scorecards(find_submissions(ROOT / "submissions"), scorer)), scorer.references)


@pytest.fixture(scope="module")
def frames(document: BoardsDocument) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The rows of the core and its pairs, as readers get them."""
    return core_frame(document.core), core_pairs_frame(document.core)


@functools.cache
def anchors() -> pd.DataFrame:
    """By task: floor, distance to the expert, the expert's standard error in that unit and its df."""
    tasks = json.loads(REFERENCES.read_text(encoding="utf-8"))["tasks"].items()
    rows = {
        task: {"floor": each["floor"]["mean"], **each["expert"]} for task, each in tasks if each["expert"]
    }
    frame = pd.DataFrame.from_dict(rows, orient="index")
    span = frame["mean"] - frame["floor"]
    error = frame["standard_error"] / span
    return pd.DataFrame({"floor": frame["floor"], "span": span, "error": error, "df": frame["episodes"] - 1})


@functools.cache
def matrices(submission: str, name: str, protocol: str = "sequential") -> NDArray[np.float64]:
    """Normalized mean returns, (runs, stages, tasks), by reading CSV files with pandas.

    The runs are the last ones that were trained here, or the author's own where there are none.
    """
    own, tasks = ROOT / "submissions" / submission, list(group(name).task_ids)
    trained = sorted(own.glob("trained/*/"), key=lambda path: int(path.name))[-1:]
    places = [each / name / protocol for each in (*trained, own)]
    folder = next(filter(Path.is_dir, places))
    logs = {
        run: pd.read_csv(folder / f"run{run}.csv", usecols=["stage", "task", "return"])
        for run in range(len(list(folder.glob("run*.csv"))))
    }
    rows = pd.concat(logs, names=["run"]).groupby(["run", "stage", "task"])["return"]
    means = (rows.mean().unstack()[tasks] - anchors()["floor"][tasks]) / anchors()["span"][tasks]
    return means.to_numpy().reshape(len(logs), -1, len(tasks))


@functools.cache
def parts(submission: str, runs: int) -> Mapping[str, Runs]:
    """What each task adds to the metrics of the core, (runs, tasks), by group."""
    found: dict[str, Runs] = {}
    for each in (matrices(submission, name)[:runs] for name in GROUPS):
        before, learned = (np.diagonal(rows, axis1=1, axis2=2) for rows in (each[:, :-1], each[:, 1:]))
        last, tasks = each[:, -1], each.shape[2]
        found.setdefault("final_performance", []).append(last / tasks)
        found.setdefault("learning_performance", []).append(learned / tasks)
        found.setdefault("forgetting", []).append((learned - last) / (tasks - 1))
        found.setdefault("zero_shot_transfer", []).append((before - each[:, 0]) / (tasks - 1))
    return found


def interval(groups: Sequence[str], shares: Runs) -> tuple[float, float, float]:
    """The mean over groups with its 95 % interval, from what each task adds in each run.

    The experts' errors are added to those of the runs. No task is in two groups of a suite or of the core.
    """
    runs = [each.sum(1) for each in shares]
    tasks = [pd.Series(each.mean(0), group(name).task_ids) for name, each in zip(groups, shares, strict=True)]
    of_task = pd.concat(tasks, verify_integrity=True)
    errors = [each.var(ddof=1) / len(each) for each in runs]
    squares = np.array([*errors, *(of_task * anchors()["error"][of_task.index]) ** 2]) / len(groups) ** 2
    df = np.array([*(len(each) - 1 for each in runs), *anchors()["df"][of_task.index]])
    total, mean = squares.sum(), np.mean([each.mean() for each in runs])
    if not total:  # PackNet's forgetting is exactly 0
        return float(mean), float(mean), float(mean)
    low, high = stats.t.interval(0.95, total**2 / (squares**2 / df).sum(), mean, total**0.5)
    return float(mean), float(low), float(high)


def pooled(first: Runs, second: Runs, *, paired: bool) -> tuple[float, float, float]:
    """The mean over groups of the differences, its standard error and Satterthwaite's degrees of freedom."""
    if paired:
        sides = [a - b for a, b in zip(first, second, strict=True)]
    else:
        sides = [side for pair in zip(first, second, strict=True) for side in pair]
    errors = np.array([side.var(ddof=1) / len(side) for side in sides]) / len(first) ** 2
    total = float(errors.sum())
    mean = float(np.mean([a.mean() - b.mean() for a, b in zip(first, second, strict=True)]))
    if not total:  # two methods that forget exactly 0: the interval is the mean
        return mean, np.finfo(np.float64).tiny, 1.0
    freedom = total**2 / sum(error**2 / (len(side) - 1) for error, side in zip(errors, sides, strict=True))
    return mean, total**0.5, freedom


def holm(p_values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Holm's adjusted p values, by the definition."""
    order = np.argsort(p_values)
    scaled = p_values[order] * np.arange(len(p_values), 0, -1)
    adjusted = np.empty_like(p_values)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(scaled))
    return adjusted


def family(differences: Sequence[tuple[float, float, float]], looks: Sequence[int]) -> pd.DataFrame:
    """Intervals, adjusted p values and verdicts of all pairs, from :func:`pooled` and the look of each."""
    mean, error, freedom = np.array(differences).T
    levels = np.array([LEVELS[look] for look in looks])
    low, high = stats.t.interval(1 - levels / len(levels), freedom, mean, error)
    alone = 2 * stats.t.sf(abs(mean / error), freedom) * 0.05 / levels
    adjusted = holm(np.minimum(1.0, alone))
    cases = [adjusted <= 0.05, (low > -0.05) & (high < 0.05)]
    verdict = np.select(cases, ["separated", "equivalent"], "open")
    return pd.DataFrame({"mean": mean, "low": low, "high": high, "p_value": adjusted, "verdict": verdict})


def assert_same_pairs(found: pd.DataFrame, expected: pd.DataFrame) -> None:
    """Asserts that the pairs of a board are those of :func:`family`."""
    ends = ["mean", "low", "high"]
    assert found[ends].to_numpy() == pytest.approx(expected[ends].to_numpy(), abs=1e-9)
    assert found["p_value"].to_numpy() == pytest.approx(expected["p_value"].to_numpy(), rel=1e-6, abs=1e-12)
    assert found["verdict"].tolist() == expected["verdict"].tolist()


def test_scores_have_the_means_and_intervals_of_scipy(document: BoardsDocument) -> None:
    # Exact but for the experts' part, which is estimated from all runs of a submission (docs/metrics.md).
    assert document.core
    rows = [row for row in document.core.rows if row.ranked]
    assert {"trpo", "reset", "multi-head", "snapshots"} <= {row.name for row in rows}
    for row in rows:
        for metric, shares in parts(row.name, row.look).items():
            value = row.metrics[metric]
            assert (value.mean, value.low, value.high) == pytest.approx(interval(GROUPS, shares), abs=1e-7)
        for name, share in zip(GROUPS, parts(row.name, row.look)["final_performance"], strict=True):
            cell = row.groups[group(name).id]
            assert (cell.mean, cell.low, cell.high) == pytest.approx(interval([name], [share]), abs=1e-6)


def test_boards_have_the_intervals_of_scipy(document: BoardsDocument) -> None:
    ranked = [(board, row) for board in document.boards for row in board.rows if row.ranked]
    assert {board.protocol for board, _ in ranked} >= {"sequential", "single", "joint"}
    for board, row in ranked:
        value = next(iter(row.metrics.values()))  # final performance, or single-task performance
        groups = [group(each).name for each in SUITES.get(board.group, (board.group,))]
        lasts = [matrices(row.name, name, board.protocol)[:, -1] for name in groups]
        assert row.runs == min(map(len, lasts))
        expected = interval(groups, [last / last.shape[1] for last in lasts])
        assert (value.mean, value.low, value.high) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("metric", ["final_performance", "forgetting"])
def test_pairs_and_ranks_have_the_intervals_and_verdicts_of_scipy(
    document: BoardsDocument, frames: tuple[pd.DataFrame, pd.DataFrame], metric: str
) -> None:
    rows, pairs = frames[0].query("ranked"), frames[1].query("metric == @metric")
    names = [name for name in rows["name"] if name in {*pairs["first"], *pairs["second"]}]
    assert list(zip(pairs["first"], pairs["second"], strict=True)) == list(combinations(names, 2))
    differences = []
    for row in pairs.to_dict("records"):
        assert row["look"] == rows.set_index("name").loc[[row["first"], row["second"]], "look"].min()
        both = row["first"], row["second"]
        starts = ([matrices(name, each)[: row["look"], :2] for each in GROUPS] for name in both)
        assert row["paired"] == all(map(np.array_equal, *starts))
        sides = ([each.sum(1) for each in parts(name, row["look"])[metric]] for name in both)
        differences.append(pooled(*sides, paired=row["paired"]))
    mine = family(differences, pairs["look"].tolist())
    assert_same_pairs(pairs, mine)
    separated = mine["verdict"] == "separated"
    is_first = (mine["mean"] > 0) == (metric == "final_performance")
    first, second = (pairs[side].reset_index(drop=True) for side in ("first", "second"))
    winners, losers = first.where(is_first, second)[separated], second.where(is_first, first)[separated]
    assert document.core
    for part in document.core.lists:  # pairs of two lists give no rank
        own = [row.name for row in part.rows if row.name in names]
        inside = winners.isin(own) & losers.isin(own)
        assert {row.name: row.metrics[metric].rank for row in part.rows if row.name in own} == {
            name: (1 + (losers[inside] == name).sum(), len(own) - (winners[inside] == name).sum())
            for name in own
        }


def test_pairs_of_normal_runs_have_all_three_verdicts_of_scipy() -> None:
    rng = np.random.default_rng(0)
    shapes = [(0.01, 0.01), (0.3, 0.02), *((0.0, deviation) for deviation in np.linspace(0.01, 0.1, 18))]
    runs = {f"m{at}": list(rng.normal(*shape, (7, 10))) for at, shape in enumerate(shapes)}
    values = {name: tuple(tuple(each.tolist()) for each in groups) for name, groups in runs.items()}
    methods = [Method(name, name, {"final_performance": each}) for name, each in values.items()]
    mine = family([pooled(*pair, paired=False) for pair in combinations(runs.values(), 2)], [10] * 190)
    assert set(mine["verdict"]) == {"separated", "equivalent", "open"}
    assert_same_pairs(pd.DataFrame(compared_pairs(methods, "final_performance")), mine)
