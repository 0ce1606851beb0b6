"""What happens to each task: scores of stages, changes, and the largest change that is significant."""

from dataclasses import replace
from pathlib import Path

import pytest
from scipy import stats

from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.group_score import GroupScore, ReferenceValue
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.submission.stages import with_stages

from ...conftest import Write

pytestmark = pytest.mark.usefixtures("known")
SCORE = GroupScore(
    level="verified",
    budget="smoke",
    runs=(0, 1),
    tasks=("a", "b"),
    metrics={},
    reference={},
    return_matrix=(),
)
EXPERT, OPEN = ReferenceValue(0.0, 100.0, False), ReferenceValue(0.0, None, True)


def two_tasks(*runs: tuple[float, float], expert: ReferenceValue = EXPERT) -> GroupScore:
    """Two tasks; per run the return on the first right after its training and at the end."""
    score = replace(
        SCORE,
        runs=tuple(range(len(runs))),
        reference={"a": expert, "b": OPEN},
        return_matrix=tuple(((0.0, 0.0), (after, 0.0), (end, 9.0)) for after, end in runs),
    )
    return with_stages(score, "sequential")


def test_the_change_is_the_end_minus_right_after_training_over_the_span() -> None:
    (change,) = two_tasks((80, 50), (90, 60)).changes
    assert change.mean == pytest.approx(-0.3)
    assert change.ends == pytest.approx((-0.3, -0.3))
    assert (change.normalized, change.is_certain) == (True, True)
    assert not two_tasks((10, 0), (10, 50)).changes[0].is_certain
    assert not two_tasks((80, 20)).changes[0].is_certain, "one run has no interval"


def test_an_open_task_has_a_raw_change_and_no_score() -> None:
    score = two_tasks((80, 50), expert=OPEN)
    assert [(each.mean, each.normalized) for each in score.changes] == [(-30.0, False)]
    assert {cell.mean for row in score.stages for cell in row} == {None}


def test_a_stage_has_the_mean_over_runs_and_its_interval() -> None:
    first, open_task = two_tasks((80, 50), (90, 150)).stages[-1]
    assert (first.mean, first.mean_return) == (1.0, 100.0)
    half = 0.5 * stats.t.ppf(0.975, 1)  # of .5 and 1.5: standard error .5
    assert first.ends == pytest.approx((1.0 - half, 1.0 + half))
    assert (open_task.mean, open_task.mean_return) == (None, 9.0)


def test_the_top_score_is_that_of_a_run_and_at_least_1() -> None:
    assert [two_tasks((80, end)).top_score for end in (50, 150)] == [1.0, 1.5]


def test_success_rates_are_averaged_over_runs_where_the_task_defines_success() -> None:
    rates = (((None, 0.25), (None, 0.5)), ((None, 0.75), (None, 1.0)))
    matrix = (((0.0, 0.0), (0.0, 0.0)),) * 2
    score = with_stages(replace(SCORE, success_rates=rates, return_matrix=matrix), "joint")
    assert [[cell.success_rate for cell in row] for row in score.stages] == [[None, 0.5], [None, 0.75]]
    assert score.changes == ()


FORGETS_HALF = "forgets HopperGravityHalf most: {} → {}"


def sentences(folder: Path, references: References | None = None) -> list[str]:
    return list(score_folder(folder, references).groups["hopper-gravity-v0"]["sequential"].highlights)


@pytest.mark.parametrize(
    ("runs", "falls", "end"),
    [
        pytest.param(5, (200, 5), 300, id="every run forgets: falls of 190, 195, 200, 205, 210"),
        pytest.param(5, (20, 200), None, id="chance explains it: falls of -380, -180, 20, 220, 420"),
        pytest.param(1, (80, 0), 420, id="one run has no interval"),
        pytest.param(5, (200, 86), None, id="falls of 28 to 372: p = .03 by itself, above .05 / 4 tasks"),
        pytest.param(5, (200, 60), 300, id="falls of 80 to 320: p = .009"),
        pytest.param(1, (49, 0), None, id="less than a twentieth of the span"),
        pytest.param(1, (51, 0), 449, id="at least a twentieth of the span"),
    ],
)
def test_what_is_forgotten_stands_out_if_it_is_certain_and_large(
    make_submission: Write, runs: int, falls: tuple[int, int], end: int | None
) -> None:
    """The return on the first task falls by so much, and by so much more from run to run."""

    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        fallen = falls[0] + falls[1] * (run - (runs - 1) / 2) if position == 1 and stage == 5 else 0.0
        return 500.0 - fallen + run / 8

    folder = make_submission(runs=tuple(range(runs)), value=value)
    assert sentences(folder) == ([] if end is None else [FORGETS_HALF.format(500, end)])


def test_what_earlier_tasks_help_is_told_over_the_runs_of_both_protocols(make_submission: Write) -> None:
    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return 500.0 + (200.0 + run) * (protocol == "sequential" and position == 3) + 50.0 * run

    folder = make_submission(protocols=("sequential", "single"), runs=(0, 1, 2), value=value)
    assert sentences(folder) == ["earlier tasks help Hopper most: 550 alone, 751 after them"]
    for file in (folder / "hopper-gravity" / "single").glob("run2.*"):
        file.unlink()
    assert sentences(folder) == ["earlier tasks help Hopper most: 525 alone, 751 after them"]


def test_an_agent_that_learned_nothing_has_no_change(make_submission: Write) -> None:
    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return -400.0 + (100.0 if protocol == "sequential" and stage >= position else 0.0) + run

    assert sentences(make_submission(runs=tuple(range(5)), value=value)) == []


def test_the_largest_is_measured_in_the_spans_of_the_tasks(
    make_submission: Write, references: References
) -> None:
    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return 500.0 - (stage == 5) * {1: 90.0, 2: 100.0}.get(position, 0.0) + run

    folder = make_submission(value=value)
    assert sentences(folder) == ["forgets HopperGravityThreeQuarters most: 500 → 400"]
    first = "gym_extensions/HopperGravityHalf-v0"
    narrow = References("x", {**references.tasks, first: Reference(Floor(0.0), Expert(500.0))})
    assert sentences(folder, narrow) == [FORGETS_HALF.format(500, 410)]


def test_help_and_harm_are_after_the_earlier_tasks_against_alone(make_submission: Write) -> None:
    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        has_trained = protocol == "sequential" and stage >= position
        return 400.0 + {2: 100.0, 3: -50.0}.get(position, 0.0) * has_trained + run / 8

    assert sentences(make_submission(value=value)) == [
        "earlier tasks help HopperGravityThreeQuarters most: 400 alone, 500 after them",
        "earlier tasks hurt Hopper most: 400 alone, 350 after them",
    ]


def test_open_tasks_are_named(make_submission: Write, references: References) -> None:
    known = {**references.tasks, "gym_extensions/Hopper-v0": Reference(Floor(0.0), None)}
    (said,) = sentences(make_submission(runs=(0,), value=lambda *_: 1.0), References("x", known))
    assert said.startswith("open (no expert)") and said.endswith(": Hopper")
