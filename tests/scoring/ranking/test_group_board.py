"""Boards: scores of the scorecards, the order, ranks with reasons, computed rows, differences of pairs."""

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from gym_extensions.catalog.groups import group
from gym_extensions.metrics.formulas import BOARD_METRICS, BY_NAME
from gym_extensions.metrics.values import Estimate, MetricValue
from gym_extensions.references import Expert, Floor, FloorAgent, Reference, References, trained_alone
from gym_extensions.scoring.pipeline import score_folder, score_folders
from gym_extensions.scoring.ranking import boards as documents
from gym_extensions.scoring.ranking.group_board import board, boards
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.submissions.review import Action, Decision, Level

from ...conftest import MANIFEST, Write
from ..made_submissions import GROUP, KEY, Enter, at_level, final_ranks, names, on_gravity


def test_scores_are_those_of_the_scorecards_and_do_not_move_when_a_submission_joins(enter: Enter) -> None:
    first, second, third = enter("a", 300), enter("b", 600), enter("c", 613)

    def scores(metrics: Mapping[str, Estimate]) -> dict[str, tuple[float | None, ...]]:
        return {name: (each.mean, each.low, each.high) for name, each in metrics.items()}

    before, after = board([first, second], KEY), board([third, first, second], KEY)
    rows, later = ({row.name: scores(row.metrics) for row in made.rows} for made in (before, after))
    assert {name: later[name] for name in "ab"} == rows
    metrics = first.groups[GROUP]["sequential"].metrics
    shown = {name: each for name, each in metrics.items() if "boards" in BY_NAME[name].shown}
    assert rows["a"] == scores(shown)
    assert (final_ranks(before), final_ranks(after)) == ([(1, 1), (2, 2)], [(1, 2), (1, 2), (3, 3)])
    assert after.published


def test_agents_that_observe_the_task_have_a_board_of_their_own(enter: Enter) -> None:
    cards = [enter("conditioned", 900, task_conditioned=True), enter("plain", 100)]
    found = {key.task_conditioned: names(board(cards, key)) for key in documents.board_keys(cards)}
    assert found == {False: ["plain"], True: ["conditioned"]}


@pytest.mark.committed
def test_a_reported_submission_is_on_a_board_without_a_rank() -> None:
    card = score_folder(Path(__file__).parents[3] / "submissions" / "henderson2017-trpo")
    made = board([card], documents.BoardKey("hopper-gravity-v0", "sequential", "paper", False))
    assert (made.ranked, made.rows[0].why) == (0, "Reported from a publication: no logs.")
    assert made.rows[0].metrics["final_performance"].mean is None


@pytest.mark.parametrize("level", ["verified", "trained here"])
def test_steps_of_runs_that_were_trained_here_are_counted(enter: Enter, level: Level) -> None:
    (row,) = board([replace(at_level(enter("a", 500), level), steps_counted=False)], KEY).rows
    assert row.steps_counted == (level == "trained here")


def test_the_order_of_the_submissions_does_not_matter(enter: Enter) -> None:
    """In any order, ties in final performance included, which the name decides."""
    cards = [enter("b", 500), enter("a", 500), enter("high", 900), enter("few", 500, runs=(0, 1))]
    made = [boards(order) for order in permutations(cards)]
    assert names(made[0].boards[0]) == ["high", "a", "b", "few"]
    assert all(other == made[0] for other in made)


def test_a_submission_on_a_suite_has_the_fewest_runs_of_its_groups(enter: Enter) -> None:
    card = on_gravity(enter("a", 300), 0.5)
    few = replace(card.groups[GROUP]["sequential"], runs=(0, 1, 2))
    card = replace(card, groups={**card.groups, GROUP: {"sequential": few}})
    (submission,) = board([card], documents.BoardKey("gravity", "sequential", "100k", False)).rows
    assert (submission.runs, submission.why) == (3, "Fewer than 5 runs.")


def test_submissions_are_sorted_by_final_performance_and_ranked_by_intervals(enter: Enter) -> None:
    made = board([enter("low", 200), enter("high", 900), enter("tied", 901)], KEY)
    assert names(made) == ["tied", "high", "low"]
    assert final_ranks(made) == [(1, 2), (1, 2), (3, 3)]
    assert made.ranked == 3
    following = [row.vs_next and (row.vs_next.name, row.vs_next.separated) for row in made.rows]
    assert following == [("high", False), ("low", True), None]
    leading = [row.vs_leader and (row.vs_leader.name, row.vs_leader.separated) for row in made.rows]
    assert leading == [None, ("tied", False), ("tied", True)]
    means: Any = [row.metrics["final_performance"].mean for row in made.rows]
    assert made.rows[2].vs_leader is not None
    assert made.rows[2].vs_leader.difference.mean == pytest.approx(means[0] - means[2])
    assert [(row.why, row.runs) for row in made.rows] == [("", 5)] * 3


def test_a_row_has_what_the_manifest_states(enter: Enter) -> None:
    card = enter("a", 500)
    (row,), stated = board([card], KEY).rows, card.manifest
    assert stated is not None
    assert (row.steps_counted, row.evaluation) == (True, "sampled")
    assert [row.authors, row.observes, row.memory] == [stated.authors, stated.observes, stated.memory]


def test_submissions_with_fewer_runs_are_below_without_a_rank_and_count_nowhere(enter: Enter) -> None:
    few = at_level(enter("few", 950, runs=(0, 1)), "verified")
    made = board([few, enter("low", 200), enter("high", 900)], KEY)
    assert names(made) == ["high", "low", "few"]
    assert final_ranks(made) == [(1, 1), (2, 2), None]
    assert made.rows[2].why == "Fewer than 5 runs."


def test_a_submission_that_learned_nothing_has_no_rank_for_forgetting(enter: Enter) -> None:
    idle = enter("idle", 0, value=lambda p, run, stage, j, e: float((run * 7 + stage * 3 + j + e) % 11) - 5)
    learner, still = board([idle, enter("learner", 900)], KEY).rows
    idle_value, value = still.metrics["forgetting"], learner.metrics["forgetting"]
    assert (idle_value.rank, idle_value.rank_note) == (None, "nothing learned to forget")
    assert (value.rank, value.rank_note) == ((1, 1), "")


def test_the_joint_gap_is_ranked_with_five_joint_runs(enter: Enter) -> None:
    both = ("sequential", "joint")
    cards = [enter("low", 200, protocols=both), enter("high", 900, protocols=both), enter("without", 500)]
    few = enter("few", 400, protocols=both)
    joint = few.groups[GROUP]["joint"]
    four = {name: replace(value, runs=value.runs[:4]) for name, value in joint.metrics.items()}
    protocols = {**few.groups[GROUP], "joint": replace(joint, metrics=four)}
    made = board([*cards, replace(few, groups={GROUP: protocols})], KEY)
    gaps = {submission.name: submission.metrics["joint_gap"] for submission in made.rows}
    # Joint returns are a fifth of the sequential ones: the gap is −.8 level, and lower is better.
    ranks = {"high": (1, 1), "low": (2, 2), "without": None, "few": None}
    assert {name: gap.rank for name, gap in gaps.items()} == ranks
    assert (gaps["few"].mean is None, gaps["few"].rank_note) == (False, "fewer than 5 runs")


def with_metrics(card: Scorecard, **values: MetricValue) -> Scorecard:
    """The scorecard with other values of some sequential metrics on ``GROUP``."""
    score = card.groups[GROUP]["sequential"]
    changed = replace(score, metrics={**score.metrics, **values})
    return replace(card, groups={GROUP: {"sequential": changed}})


def test_a_submission_without_final_performance_has_its_reason_and_no_rank(enter: Enter) -> None:
    card = with_metrics(enter("a", 300), final_performance=MetricValue(why="Every task is open."))
    (submission,) = board([card], KEY).rows
    assert (submission.ranked, submission.why) == (False, "Every task is open.")
    assert submission.metrics["learning_performance"].mean is not None


def test_a_rank_needs_verified_logs(enter: Enter) -> None:
    made = board([at_level(enter("claimed", 900), "claimed"), enter("verified", 100)], KEY)
    assert [(submission.name, submission.level, submission.ranked) for submission in made.rows] == [
        ("verified", "verified", True),
        ("claimed", "claimed", False),
    ]
    assert made.ranked == 1
    assert made.rows[1].why.startswith("Claimed:")
    assert board([at_level(enter("again", 300), "trained here")], KEY).ranked == 1


def test_a_metric_that_needs_other_runs_is_ranked_only_if_they_are_verified(enter: Enter) -> None:
    both = enter("a", 300, protocols=("sequential", "single", "joint"))
    for protocol, metric in (("single", "asymptotic_transfer"), ("joint", "joint_gap")):
        (submission,) = board([at_level(both, "claimed", protocol)], KEY).rows
        assert submission.metrics[metric].rank is None
        assert protocol in submission.metrics[metric].rank_note
        assert submission.metrics["final_performance"].rank == (1, 1)
    (submission,) = board([both], KEY).rows
    assert (submission.metrics["joint_gap"].rank, submission.metrics["joint_gap"].rank_note) == ((1, 1), "")


def test_a_metric_with_fewer_runs_than_the_submission_has_a_note_and_no_rank(enter: Enter) -> None:
    card = with_metrics(enter("a", 300), forward_transfer_auc=MetricValue(0.3, runs=(0.1, 0.3, 0.5)))
    (submission,) = board([card], KEY).rows
    value = submission.metrics["forward_transfer_auc"]
    assert submission.ranked
    assert (value.mean, value.rank, value.rank_note) == (0.3, None, "fewer than 5 runs")


def test_a_withdrawn_submission_is_on_no_board_and_an_accepted_one_has_its_date(enter: Enter) -> None:
    def decided(action: Action) -> Scorecard:
        decision = Decision(action=action, by="M.", date="2026-01-02", reason="why")
        return replace(enter("a", 300), decisions=(decision,))

    assert boards([decided("withdrawn")]) == documents.BoardsDocument(boards=())
    assert board([decided("withdrawn")], KEY).rows == ()
    assert boards([decided("accepted")]).boards[0].rows[0].accepted == "2026-01-02"
    assert boards([enter("a", 300)]).boards[0].rows[0].accepted == ""


@pytest.mark.parametrize("group", [GROUP, "gravity"])
def test_random_and_zero_are_computed_from_the_floors(
    enter: Enter, references: References, group: str
) -> None:
    cards = [on_gravity(enter("a", 300), 0.5)]
    key = documents.BoardKey(group, "sequential", "100k", False)
    floor = Floor(0.0, agents={"random": FloorAgent(-250.0), "zero": FloorAgent(100.0)})
    tasks = {name: Reference(floor, task.expert) for name, task in references.tasks.items()}
    made = board(cards, key, References("synthetic", tasks))
    assert [floor.name for floor in made.computed] == ["random", "zero"]
    random = {name: value.mean for name, value in made.computed[0].metrics.items()}
    assert list(random) == [metric.name for metric in BOARD_METRICS["sequential"]]
    assert random["final_performance"] == random["learning_performance"] == -0.25
    differences = ("forgetting", "zero_shot_transfer", "asymptotic_transfer", "joint_gap")
    assert {random[name] for name in differences} == {0}
    assert (random["forward_transfer_auc"], random["cvar_10"]) == (None, None)
    assert made.computed[1].metrics["final_performance"].mean == 0.1
    assert {value.rank for floor in made.computed for value in floor.metrics.values()} == {None}
    assert (names(made), made.ranked) == (["a"], 1)


def at_300k(card: Scorecard) -> Scorecard:
    """The scorecard as if it were of the budget of the row of each task alone."""
    scores = {"sequential": replace(card.groups[GROUP]["sequential"], budget="300k")}
    return replace(card, groups={GROUP: scores})


KEY_300K = documents.BoardKey(GROUP, "sequential", "300k", False)


def test_the_reference_agent_on_each_task_alone_is_a_row(enter: Enter, references: References) -> None:
    first = group("hopper-gravity").task_ids[0]
    known = References("x", {**references.tasks, first: Reference(Floor(0.0), Expert(1000.0, 100.0, 1000))})
    made = board([at_300k(enter("a", 300))], KEY_300K, known)
    (alone,) = [row for row in made.computed if row.name == "alone"]
    final = alone.metrics["final_performance"]
    runs = {task: trained_alone()[task].runs for task in group("hopper-gravity").task_ids}
    tasks = [np.array([run.mean / 1000 for run in each]) for each in runs.values()]
    assert final.mean == pytest.approx(np.mean(tasks))
    # Runs are independent between tasks. The expert's error is 100 / 1000 on one task.
    squares = [float(np.var(each, ddof=1)) / 5 / 25 for each in tasks]
    anchor = (float(tasks[0].mean()) / 5 * 0.1) ** 2
    total = sum(squares) + anchor
    df = total**2 / (sum(square**2 / 4 for square in squares) + anchor**2 / 999)
    assert final.high == pytest.approx(final.mean + stats.t.ppf(0.975, df) * math.sqrt(total))
    assert "only its returns at the end" in alone.metrics["forgetting"].why
    assert made.ranked == 1


def test_without_its_budget_or_beside_a_submission_of_that_name_there_is_no_row_alone(
    enter: Enter, references: References
) -> None:
    card = enter("a", 300)
    assert board([card], KEY, references).computed == ()
    assert board([at_300k(card), at_300k(replace(card, name="alone"))], KEY_300K, references).computed == ()


def test_every_pair_has_welchs_interval_and_p_value_of_every_metric_of_both(enter: Enter) -> None:
    cards = [enter("high", 900), enter("low", 200), enter("few", 500, runs=(0,))]
    made = board(cards, KEY)
    pairs = [("high", "low"), ("high", "few"), ("low", "few")]
    assert [(pair.first, pair.second) for pair in made.pairs] == pairs
    runs = [card.groups[GROUP]["sequential"].metrics["forgetting"].runs for card in cards[:2]]
    expected = stats.ttest_ind(*runs, equal_var=False)
    found = made.pairs[0].metrics["forgetting"]
    interval = expected.confidence_interval(0.95)
    assert [found.low, found.high] == pytest.approx([interval.low, interval.high])
    assert found.p_value == pytest.approx(expected.pvalue, rel=1e-9)
    alone = made.pairs[1].metrics["final_performance"]
    assert (alone.low, alone.high, alone.p_value) == (None, None, None)


def test_a_row_names_the_other_submissions_of_its_author_and_family(
    tmp_path: Path, make_submission: Write
) -> None:
    families = [("A. Author", "trpo"), ("a.  author", " TRPO_2"), ("A. Author", "sac"), ("B. Author", "trpo")]
    for name, (author, algorithm) in zip("abcd", families, strict=True):
        manifest = MANIFEST.replace('"smoke"', '"100k"').replace("A. Nonymous", author)
        manifest = manifest.replace('algorithm = "formula"', f'algorithm = "{algorithm}"')
        make_submission(name=name, protocols=("single",), runs=(0,), manifest=manifest)
    (board,) = boards(score_folders([tmp_path]).submissions).boards
    assert {row.name: row.related for row in board.rows} == {"a": ("b",), "b": ("a",), "c": (), "d": ()}
