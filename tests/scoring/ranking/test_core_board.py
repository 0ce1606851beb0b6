"""The core board: pooled differences, looks, families of all pairs, verdicts, notes and costs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from gym_extensions.metrics.statistics import ALPHA
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.group_score import GroupScore, ReferenceValue, RunProvenance
from gym_extensions.scoring.ranking import core_board as core_boards
from gym_extensions.scoring.ranking.boards import CorePair
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission import core_score
from gym_extensions.scoring.submission.core_score import LOOKS, last_look, next_look
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.review import Decision
from gym_extensions.submissions.run import Memory, consecutive

from ..made_submissions import Enter, at_level
from .conftest import (
    FINAL,
    GROUPS,
    OnCore,
    board_of,
    normal,
    pair_of,
    ranked,
    row,
    unverified,
    with_episodes,
)


def test_looks_are_prescribed() -> None:
    assert LOOKS == (5, 10, 20, 40, 80)
    assert [last_look(runs) for runs in (0, 4, 5, 19, 20, 99)] == [0, 0, 5, 10, 20, 80]
    assert [next_look(look) for look in (0, 5, 80)] == [5, 10, None]
    assert [consecutive(runs) for runs in ((), (1, 2), (0, 1, 3), range(7))] == [0, 0, 2, 7]


def test_the_pooled_difference_by_hand() -> None:
    # Differences 1 and 3; squared errors (1 + 1)/3 and (4 + 1)/3, together 7/3 over 2² groups.
    first, second = ((1.0, 2.0, 3.0), (3.0, 5.0, 7.0)), ((0.0, 1.0, 2.0), (1.0, 2.0, 3.0))
    unpaired = core_boards.pooled_difference(first, second, 3, paired=False)
    assert (unpaired.mean, unpaired.squared_error) == pytest.approx((2.0, 7 / 12), rel=1e-14)
    assert unpaired.df == pytest.approx((7 / 3) ** 2 / ((1 + 1 + 16 + 1) / 9 / 2), rel=1e-14)
    # Differences of runs 1, 1, 1 and 2, 3, 4: the first group has no error, the second 1/3.
    paired = core_boards.pooled_difference(first, second, 3, paired=True)
    assert (paired.mean, paired.squared_error, paired.df) == pytest.approx((2.0, 1 / 12, 2.0), rel=1e-14)


def test_one_group_is_welchs_test_or_the_paired_test_of_scipy() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.normal(0, 1, 10).tolist(), rng.normal(1, 3, 10).tolist()
    for paired, test in ((False, stats.ttest_ind(a, b, equal_var=False)), (True, stats.ttest_rel(a, b))):
        found = core_boards.pooled_difference([a], [b], 10, paired=paired)  # type: ignore[arg-type]
        assert found.mean / math.sqrt(found.squared_error) == pytest.approx(test.statistic, rel=1e-12)
        assert found.df == pytest.approx(test.df, rel=1e-12)


def compared(first: str, second: str, mean: float, p_value: float, half_width: float = 1.0) -> CorePair:
    low, high = mean - half_width, mean + half_width
    return core_boards.decided(CorePair(first, second, 5, False, mean, low, high, p_value, "open", True, 10))


def test_ranks_of_all_pairs_by_hand() -> None:
    pairs = [compared("a", "b", 1, 0.04), compared("a", "c", 2, 0.01), compared("b", "c", 1, 0.2)]
    assert core_boards.ranks("abc", pairs, "higher") == {"a": (1, 1), "b": (2, 3), "c": (2, 3)}
    assert core_boards.ranks("abc", pairs, "lower") == {"a": (3, 3), "b": (1, 2), "c": (1, 2)}


@pytest.mark.parametrize(
    ("mean", "p_value", "half_width", "verdict"),
    [
        (-0.02, 1.0, 0.02, "equivalent"),
        (0.02, 1.0, 0.02, "equivalent"),
        (-0.02, 1.0, 0.04, "open"),
        (0.02, 1.0, 0.04, "open"),
        (-0.02, ALPHA, 0.02, "separated"),
    ],
)
def test_equivalent_means_an_interval_inside_the_margin(
    mean: float, p_value: float, half_width: float, verdict: str
) -> None:
    pair = compared("a", "b", mean, p_value, half_width)
    assert (core_boards.MARGIN, pair.verdict) == (0.05, verdict)
    assert (pair.next_look is None) == (verdict != "open")


def test_a_board_has_one_row_per_method_and_every_pair(on_core: OnCore) -> None:
    levels = {"low": 0.2, "high": 0.9, "near": 0.88}
    board = board_of([on_core(name, normal(seed, mean)) for seed, (name, mean) in enumerate(levels.items())])
    assert (board.suite, board.groups, board.looks, ranked(board)) == ("core-v1", GROUPS, LOOKS, 3)
    assert [submission.name for submission in board.rows][-1] == "low"
    assert row(board, "low").metrics[FINAL].rank == (3, 3)
    assert row(board, "high").metrics[FINAL].rank == (1, 2)
    assert {pair_of(board, "low", other).verdict for other in ("high", "near")} == {"separated"}
    assert (pair_of(board, "high", "near").verdict, pair_of(board, "high", "near").next_look) == ("open", 10)
    assert all(pair.exploratory for pair in board.pairs[FINAL])
    mean = row(board, "high").metrics[FINAL].mean
    assert mean == pytest.approx(np.mean(list(normal(1, 0.9).values())), rel=1e-12)


def test_a_submission_with_part_of_the_core_is_shown_without_a_core_score(on_core: OnCore) -> None:
    part = {group: values for group, values in normal(1, 0.5).items() if group != GROUPS[2]}
    board = board_of([on_core("part", part), on_core("whole", normal(2, 0.5))])
    assert [each.name for each in board.rows] == ["whole", "part"]
    submission = row(board, "part")
    assert (submission.ranked, submission.missing) == (False, (GROUPS[2],))
    assert submission.metrics[FINAL].mean is None
    assert submission.groups[GROUPS[0]].mean == pytest.approx(np.mean(part[GROUPS[0]]))
    assert submission.notes == (f"partial-core: It has no sequential runs of {GROUPS[2]}.",)
    assert submission.cost.steps is None
    assert submission.cost.stored_steps is not None, "memory is that of the groups that it has"


def test_a_submission_without_a_score_in_a_group_says_why(on_core: OnCore) -> None:
    card = on_core("a", normal(1, 0.5))
    log = card.groups[GROUPS[1]]["sequential"]
    none = MetricValue(why="A task is open.")
    without = replace(log, metrics={**log.metrics, FINAL: none})
    card = replace(card, groups={**card.groups, GROUPS[1]: {"sequential": without}})
    submission = row(board_of([card, on_core("b", normal(2, 0.5))]), "a")
    assert not submission.ranked
    assert submission.metrics[FINAL].why == f"No score in {GROUPS[1]}: A task is open."


def test_runs_beyond_a_look_and_different_numbers_are_noted_and_not_compared(on_core: OnCore) -> None:
    ten, twelve = normal(1, 0.5, 10), normal(1, 0.5, 12)
    more = {**ten, GROUPS[0]: (*twelve[GROUPS[0]][:10], 99.0, 99.0)}
    exact, beyond = (
        board_of([on_core("a", normal(3, 0.5, 10)), on_core("b", each)])
        for each in ({**more, GROUPS[0]: more[GROUPS[0]][:10]}, more)
    )
    assert beyond.pairs == exact.pairs
    assert row(beyond, "b").metrics == row(exact, "b").metrics
    notes = [note.partition(":")[0] for note in row(beyond, "b").notes]
    assert notes == ["different-numbers-of-runs", "runs-beyond-the-look"]
    assert row(exact, "b").notes == ()


def test_runs_that_are_not_verified_yet_wait_and_change_nothing(on_core: OnCore) -> None:
    ten = on_core("b", normal(1, 0.5, 10))
    twelve = on_core("b", {group: (*values, 99.0, 99.0) for group, values in normal(1, 0.5, 10).items()})
    other = on_core("a", normal(3, 0.5, 10))
    before, after = (board_of([other, card]) for card in (ten, unverified(twelve, 10, 11)))
    assert after.pairs == before.pairs
    waiting = row(after, "b")
    assert (waiting.ranked, waiting.level, waiting.look) == (True, "verified", 10)
    assert waiting.metrics == row(before, "b").metrics
    assert [note.partition(":")[0] for note in waiting.notes] == ["unverified-runs"]
    assert row(board_of([unverified(ten, 7)]), "b").look == 5
    few = row(board_of([unverified(ten, 3)]), "b")
    assert (few.ranked, few.why.partition(":")[0], few.level) == (False, "Claimed", "claimed")


def test_a_missing_number_keeps_the_earlier_look(on_core: OnCore) -> None:
    numbers = {GROUPS[0]: (0, 1, 2, 3, 4, 5, 6, 8, 9, 10)}
    submission = row(board_of([on_core("a", normal(1, 0.5, 10), runs=numbers)]), "a")
    assert (submission.look, submission.groups[GROUPS[0]].runs) == (5, 5)


def test_runs_are_paired_with_the_same_parent_and_equal_starts_alone(on_core: OnCore) -> None:
    cards = [
        on_core("base", normal(1, 0.5), parent="trpo"),
        on_core("alike", normal(2, 0.5), parent="trpo"),
        on_core("parent", normal(4, 0.5), parent="sac"),
        on_core("start", normal(3, 0.5), parent="trpo", starts=1),
    ]
    board = board_of(cards)
    paired = [pair_of(board, "base", name).paired for name in ("alike", "parent", "start")]
    assert paired == [True, False, False]


def test_runs_unusually_alike_on_one_group_are_marked_with_the_group_and_ranked(on_core: OnCore) -> None:
    alike = {**normal(3, 0.5), GROUPS[1]: (0.5, 0.5001, 0.5002, 0.5001, 0.5)}
    board = board_of([on_core("a", normal(1, 0.5)), on_core("b", normal(2, 0.5)), on_core("one-run", alike)])
    assert (row(board, "one-run").alike.partition(":")[0], row(board, "one-run").ranked) == (GROUPS[1], True)
    assert {each.name for each in board.rows if each.alike} == {"one-run"}


def test_a_run_that_waits_for_verification_changes_neither_copies_nor_marks(on_core: OnCore) -> None:
    alike = dict.fromkeys(GROUPS, (0.5, 0.5001, 0.5002, 0.5001, 0.5, 0.9))
    original = unverified(with_episodes(on_core("original", alike)), 5)
    first = replace(original, decisions=(Decision(action="accepted", by="M.", date="2026-01-01", reason=""),))
    cards = [first, with_episodes(on_core("a copy", alike)), on_core("b", normal(1, 0.5))]
    board = board_of([*cards, on_core("c", normal(2, 0.5))])
    assert row(board, "original").ranked
    assert row(board, "a copy").why == "Has most episodes of original."
    assert {each.name for each in board.rows if each.alike} == {"original"}


def test_a_claimed_submission_and_a_copy_have_no_rank(on_core: OnCore) -> None:
    claimed = at_level(on_core("claimed", normal(1, 0.9)), "claimed")
    board = board_of([claimed, *(with_episodes(on_core(name, normal(2, 0.5))) for name in ("a", "b"))])
    assert [submission.name for submission in board.rows if submission.ranked] == ["a"]
    assert row(board, "b").why == "Has most episodes of a."
    assert row(board, "claimed").why.startswith("Claimed")


def test_forgetting_is_compared_among_those_that_learned(on_core: OnCore) -> None:
    means = {"a": 0.5, "b": 0.5, "idle": 0.0}
    board = board_of(
        [on_core(name, normal(seed, mean)) for seed, (name, mean) in enumerate(means.items(), 1)]
    )
    (pair,) = board.pairs["forgetting"]
    assert {pair.first, pair.second} == {"a", "b"}
    assert row(board, "idle").metrics["forgetting"].rank_note == "nothing learned to forget"
    assert len(board.pairs[FINAL]) == 3


def test_methods_with_the_task_label_are_ranked_apart_and_compared_with_all(on_core: OnCore) -> None:
    def observing(card: Scorecard) -> Scorecard:
        assert card.manifest is not None
        return replace(card, manifest=replace(card.manifest, observes=Observes(task_in_evaluation=True)))

    levels = {"low": 0.2, "high": 0.9, "labelled": 0.95, "poor": 0.1}
    cards = [on_core(name, normal(seed, mean)) for seed, (name, mean) in enumerate(levels.items())]
    board = board_of([observing(card) if card.name in ("labelled", "poor") else card for card in cards])
    lists = {part.task_conditioned: [each.name for each in part.rows] for part in board.lists}
    assert lists == {False: ["high", "low"], True: ["labelled", "poor"]}
    ranked = {each.name: each.metrics[FINAL].rank for each in board.rows}
    assert ranked == {"high": (1, 1), "low": (2, 2), "labelled": (1, 1), "poor": (2, 2)}
    assert len(board.pairs[FINAL]) == 6, "also across the lists"


def test_a_variant_has_the_score_and_the_ranks_of_the_groups_that_are_left(on_core: OnCore) -> None:
    """The better one is ahead in the walls alone; without them it is behind."""
    levels = {"walls": {True: 0.9, False: 0.2}, "others": {True: 0.1, False: 0.5}}
    rng = np.random.default_rng(0)
    cards = [
        on_core(name, {group: rng.normal(mean["-wall-" in group], 0.01, 5) for group in GROUPS})
        for name, mean in levels.items()
    ]
    board = board_of(cards)
    variants = {variant.name: variant for variant in board.variants}
    assert [name.partition("-")[2] for name in variants][:6] == [
        *("Hopper", "Walker2d", "HalfCheetah"),
        *("gravity", "body", "wall"),
    ]
    assert [each.name for each in board.rows] == ["walls", "others"]
    left = variants["without-wall"]
    assert left.groups == tuple(group for group in GROUPS if "-wall-" not in group)
    assert (left.scores["others"].place, left.scores["walls"].place) == (1, 2)
    assert (left.scores["others"].rank, left.scores["walls"].rank) == ((1, 1), (2, 2))
    assert left.scores["walls"].mean == pytest.approx(0.2, abs=0.02)
    middle = variants["interquartile-mean"].scores["walls"]
    scores = core_score.final_scores(core_score.core_logs(cards[0]).values(), 5)
    assert middle.mean == pytest.approx(stats.trim_mean(np.concatenate(scores).ravel(), 0.25))


def test_the_interquartile_mean_compares_the_same_number_of_runs(on_core: OnCore) -> None:
    """The first runs of both are equal; five more of one of them are better, and not compared yet."""
    few = normal(1, 0.3)
    cards = [
        on_core("few", few),
        on_core("many", {name: (*runs, *(1.0 + run for run in runs)) for name, runs in few.items()}),
    ]
    for card in cards:
        for each in card.groups.values():
            log = each["sequential"]
            reference = dict.fromkeys(log.tasks, ReferenceValue(0.0, 1.0))
            ends = log.metrics[FINAL].runs
            matrix = tuple(((0.0, 0.0), (0.0, 0.0), (end, end)) for end in ends)
            each["sequential"] = replace(log, reference=reference, return_matrix=matrix)
    variants = {variant.name: variant.scores for variant in board_of(cards).variants}
    assert {score.rank for score in variants["interquartile-mean"].values()} == {(1, 2)}


def test_what_is_kept_is_a_share_of_what_was_learned(on_core: OnCore) -> None:
    card = on_core("a", normal(1, 0.5), starts=5)
    for each in card.groups.values():
        log = each["sequential"]
        reference = {log.tasks[0]: ReferenceValue(0.0, 1.0)}
        matrix = tuple(((0.0, 0.0), (2.0 + run, 0.0), (1.0 + run, 0.0)) for run in range(5))
        each["sequential"] = replace(log, reference=log.reference | reference, return_matrix=matrix)
    kept = row(board_of([card]), "a").retention
    assert kept.mean == pytest.approx(3.0 / 4.0)
    assert kept.low is not None and kept.low < 0.75 < (kept.high or 0.0)


def test_who_learned_less_than_each_task_alone_has_no_rank_for_forgetting(on_core: OnCore) -> None:
    base = on_core("trpo", normal(0, 0.5))
    single = MetricValue(mean=0.5, runs=(0.49, 0.5, 0.51, 0.5, 0.5))
    groups = {}
    for name, logs in base.groups.items():
        alone = replace(logs["sequential"], metrics={"single_task_performance": single}, runs=tuple(range(5)))
        groups[name] = {**logs, "single": alone}
    cards = [on_core("poor", normal(1, 0.1)), on_core("good", normal(2, 0.6))]
    board = board_of([replace(base, groups=groups), *cards])
    poor, good = (row(board, name).metrics["forgetting"] for name in ("poor", "good"))
    assert (poor.rank, poor.rank_note.partition(":")[0]) == (None, "little learned")
    assert (good.rank, good.rank_note) == ((1, 2), "")
    assert board.pair("forgetting", "poor", "good") is None


def test_a_cost_is_measured_or_absent(on_core: OnCore) -> None:
    card = on_core("a", normal(1, 0.5))

    def with_cost(group: str, run: RunProvenance) -> RunProvenance:
        seconds = None if group == GROUPS[0] and run.run else 10.0 + run.run
        return replace(
            run,
            steps=1000,
            cpu_seconds=seconds,
            peak_memory_mb=50.0 + run.run,
            memory=Memory(stored_steps=7, parameters_first=3, parameters_last=4 if run.run else 400),
        )

    def timed_runs(card: Scorecard) -> tuple[int, int] | None:
        cost = core_score.run_cost(card)
        return cost.timed_runs if cost else None

    groups = {}
    for group, logs in card.groups.items():
        provenance = tuple(with_cost(group, run) for run in logs["sequential"].provenance)
        groups[group] = {"sequential": replace(logs["sequential"], provenance=provenance)}
    # One run of the first group states its time; the first of each the largest memory of its submission.
    timed = replace(card, groups=groups)
    assert timed_runs(timed) == (1, 5)
    cost = board_of([timed]).rows[0].cost
    assert (cost.steps, cost.cpu_seconds) == (7000, 10 + 6 * 12)
    assert (cost.peak_memory_mb, cost.stored_steps, cost.parameters) == (54, 7, 4)
    assert board_of([card]).rows[0].cost.cpu_seconds is None
    assert timed_runs(card) == (0, 0)


def test_another_budget_is_not_on_the_core(enter: Enter) -> None:
    assert core_boards.core_board([enter("a", 300)]) is None


def test_the_reference_agent_in_other_ways_has_rows_without_a_rank(on_core: OnCore) -> None:
    def joint(log: GroupScore, mean: float) -> GroupScore:
        runs = tuple(mean + 0.01 * run for run in range(6))
        return replace(log, runs=tuple(range(6)), metrics={FINAL: MetricValue(mean=mean, runs=runs)})

    card = on_core("trpo", normal(0, 0.5))
    means = dict(zip(GROUPS, np.linspace(0.3, 0.9, len(GROUPS)), strict=True))
    groups = {
        name: {**logs, "joint": joint(logs["sequential"], means[name])} for name, logs in card.groups.items()
    }
    board = board_of([replace(card, groups=groups), on_core("other", normal(1, 0.5))])
    (found,) = board.references
    assert (found.name, found.runs, ranked(board)) == ("joint", 5, 2)
    assert found.value.mean == pytest.approx(0.6 + 0.02)  # runs 0 to 4 of 6
    assert found.groups[GROUPS[0]].mean == pytest.approx(0.3 + 0.02)
    incomplete = dict(groups) | {GROUPS[0]: card.groups[GROUPS[0]]}
    assert board_of([replace(card, groups=incomplete)]).references == ()
    claimed = at_level(replace(card, groups=groups), "claimed", "joint")
    assert board_of([claimed]).references == ()
