"""Runs in other orders: what a scorecard has of them, and runs whose order is not that of their place."""

import shutil
from pathlib import Path

import pytest

from gym_extensions import results
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import task_order
from gym_extensions.references import References
from gym_extensions.scoring.submission.scorer import score
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.run import order_of

from ...conftest import Write
from ...submissions.examples import document

GROUP = group("hopper-gravity")
TASK, PLACE = (0.0, 40.0, 10.0, 30.0, 70.0), (0.0, 10.0, 20.0, 30.0, 40.0)
"""Returns of a task at the end, and what its position adds."""


def additive(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    """A return at the end that is due to the task and its place alone; 5 less before the end."""
    place = task_order(protocol, run, 5).index(position - 1)
    return 100 + TASK[position - 1] + PLACE[place] - 5 * (stage < 5) + spread(run, episode)


def spread(run: int, episode: int) -> float:
    """What makes runs differ, and is 0 on average over the episodes."""
    return (run + 1) * (episode - 9.5) / 100


def test_balanced_runs_tell_the_task_from_its_position(
    make_submission: Write, references: References
) -> None:
    folder = make_submission(runs=tuple(range(11)), protocols=("balanced",), value=additive)
    scored = score(read(folder), references).groups[GROUP.id]["balanced"]
    effects, reference = scored.order_effects["final_performance"], scored.reference[GROUP.task_ids[0]]
    assert reference.span
    for got, added in ((effects.position, PLACE), (effects.task, TASK)):
        means = [each.mean for each in got if each.mean is not None]
        assert [mean - means[0] for mean in means] == pytest.approx([each / reference.span for each in added])
    total = 5 * 4 * (sum((each - 20) ** 2 for each in PLACE) + sum((each - 30) ** 2 for each in TASK))
    expected = {"position": 20 * 1000 / total, "task": 20 * 3000 / total, "rest": 0.0}
    assert {name: each.mean for name, each in effects.shares.items()} == pytest.approx(expected)
    forgotten = [each.mean for each in scored.order_effects["forgetting"].position]
    assert forgotten == pytest.approx([-5 / reference.span] * 4 + [None])


def test_metrics_follow_the_order_of_each_run(make_submission: Write, references: References) -> None:
    """Each task has a return of 100 from the stage that trains it on."""

    def learned(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        is_trained = task_order(protocol, run, 5).index(position - 1) < stage
        return 100.0 * is_trained + spread(run, episode)

    protocols = ("sequential", "descending", "balanced")
    folder = make_submission(runs=(0, 1, 2), protocols=protocols, value=learned)
    found = score(read(folder), references).groups[GROUP.id]
    one = {name: value.mean for name, value in found["sequential"].metrics.items() if value.mean is not None}
    assert one["forgetting"] == one["zero_shot_transfer"] == 0
    for protocol in ("descending", "balanced"):
        same = found[protocol].metrics
        assert {name: same[name].mean for name in one if name in same} == pytest.approx(one)
        assert not found[protocol].order_effects


def test_the_effects_are_a_data_frame(make_submission: Write) -> None:
    folder = make_submission(runs=tuple(range(10)), protocols=("balanced", "sequential"), value=additive)
    frame = results.order_effects(folder)
    counts = {"final_performance": (5, 3, 5), "forgetting": (4, 3, 5)}
    sizes = frame.groupby(["metric", "kind"]).size().unstack()[["position", "share", "task"]]
    assert {metric: tuple(row) for metric, row in sizes.iterrows()} == counts
    assert results.order_effects(make_submission(name="ascending")).empty


def moved(folder: Path, origin: str, target: str) -> str:
    """The files of a run at the place of another one, whose number and protocol the document then states."""
    protocol, run = target.split("/run")
    for path in (folder / GROUP.name).glob(f"{origin}.*"):
        place = folder / GROUP.name / f"{target}{path.suffix}"
        place.parent.mkdir(exist_ok=True)
        shutil.copy(path, place)
    document(f"{GROUP.name}/{target}.json", protocol=protocol, run=int(run))(folder)
    return f"{GROUP.name}/{target}.json, order"


@pytest.mark.parametrize(
    ("origin", "target"),
    [
        ("balanced/run1", "balanced/run0"),
        ("balanced/run1", "sequential/run1"),
        ("balanced/run1", "descending/run1"),
        ("sequential/run1", "balanced/run1"),
    ],
)
def test_a_run_whose_order_is_not_the_row_of_its_number_is_named(
    origin: str, target: str, make_submission: Write
) -> None:
    folder = make_submission(protocols=("sequential", "balanced"))
    where = moved(folder, origin, target)
    (found,) = [each for each in read(folder).problems if each.rule == "wrong-order"]
    protocol, run = target.split("/run")
    expected = ", ".join(order_of(GROUP, protocol, int(run)))[:60] or "no order"
    assert found.where == where
    assert f"the document of {protocol} run {run} states {expected}" in found.message


def test_a_curve_of_another_row_is_named(make_submission: Write) -> None:
    folder = make_submission(protocols=("balanced",), curves=2)
    moved(folder, "balanced/run1", "balanced/run0")
    document(f"{GROUP.name}/balanced/run0.json", order=order_of(GROUP, "balanced", 0))(folder)
    assert "foreign-curve" in {each.rule for each in read(folder).problems}
