"""The second edition of the core ranks what was trained here; an author's own runs are a claim beside it."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from gym_extensions.scoring.ranking.core_board import PLANNED, lacking
from gym_extensions.scoring.scorecard import TrainingSummary
from gym_extensions.scoring.submission.core_score import claim_of, core_score, run_cost

from .conftest import (
    FINAL,
    GROUPS,
    OnCore,
    Values,
    board_of,
    normal,
    ranked,
    row,
    trained,
    with_logs,
)


def test_copies_and_marks_are_of_the_runs_that_were_trained_here(on_core: OnCore) -> None:
    """In the second edition the author's own runs are a claim."""
    alike: Values = dict.fromkeys(GROUPS, (0.5, 0.5001, 0.5002, 0.5001, 0.5))
    honest = normal(1, 0.5)
    made = {
        "trpo": (honest, honest),
        "b": (honest, honest),
        "claim": (alike, honest),
        "runs": (honest, alike),
    }
    board = board_of([trained(on_core(name, own), here) for name, (own, here) in made.items()])
    assert ranked(board) == 4
    assert {each.name for each in board.rows if each.alike} == {"runs"}


def test_the_first_edition_ranks_verified_runs_and_those_that_were_trained_here(on_core: OnCore) -> None:
    source = on_core("a", normal(1, 0.5))
    card = replace(trained(source, normal(2, 0.7)), name="new")
    board = board_of([card, on_core("trpo", normal(3, 0.3))])
    assert (board.edition, ranked(board)) == (1, 2)
    new = row(board, "new")
    assert (new.level, new.trained_here) == ("trained here", True)
    assert new.metrics[FINAL].mean == pytest.approx(np.mean(list(normal(2, 0.7).values())), rel=1e-12)


def test_the_cost_is_that_of_the_runs_that_are_compared(on_core: OnCore) -> None:
    card = trained(on_core("new", normal(1, 0.5)), normal(2, 0.7))
    run = card.own[GROUPS[0]].provenance[0]
    card = with_logs(card, provenance=(replace(run, steps=999),))
    cost = run_cost(replace(card, core=core_score(card)))
    assert cost is not None
    assert cost.steps == row(board_of([card]), "new").cost.steps == len(GROUPS) * 999 != run.steps


def test_the_second_edition_ranks_what_was_trained_here_alone(on_core: OnCore) -> None:
    trpo = trained(on_core("trpo", normal(3, 0.3)), normal(4, 0.3))
    other = trained(on_core("other", normal(3, 0.9)), normal(4, 0.9))
    board = board_of([trpo, other, on_core("verified", normal(1, 0.95))])
    assert (board.edition, ranked(board)) == (2, 2)
    last = row(board, "verified")
    assert (last.ranked, last.why, board.rows[-1].name) == (False, "Not trained here.", "verified")
    assert last.metrics[FINAL].mean == pytest.approx(np.mean(list(normal(1, 0.95).values())), rel=1e-12)


METHODS = lacking({})
"""Of the plan."""


def planned(runs: Mapping[str, int], on_core: OnCore) -> list[tuple[str, frozenset[str]]]:
    """The metric and pair of each planned comparison, for submissions with these numbers of runs."""
    cards = [
        trained(on_core(name, normal(at, 0.3, runs=20)), normal(9 + at, 0.3, runs=count))
        for at, (name, count) in enumerate(runs.items())
    ]
    pairs = [(metric, pair) for metric, found in board_of(cards).pairs.items() for pair in found]
    return [(metric, frozenset((p.first, p.second))) for metric, p in pairs if not p.exploratory]


def test_in_the_second_edition_pairs_are_exploratory_that_the_plan_does_not_name(on_core: OnCore) -> None:
    found = planned(dict.fromkeys(METHODS, 10), on_core)
    assert len(METHODS) == 10
    assert set(found) == {(metric, frozenset(names)) for _, *names, metric in PLANNED}


@pytest.mark.parametrize("other", [{"reset": 5}, {"ppo-tuned": 0}, {"trpo": 20}, {"stranger": 10}])
def test_a_pair_is_tested_once_with_ten_runs_of_the_methods_of_the_plan(
    on_core: OnCore, other: dict[str, int]
) -> None:
    runs = dict.fromkeys(METHODS, 10) | other
    assert lacking(runs) == [name for name, count in other.items() if count < 10]
    assert planned({name: count for name, count in runs.items() if count}, on_core) == []


def test_all_pairs_of_the_first_edition_are_exploratory(on_core: OnCore) -> None:
    board = board_of([on_core(name, normal(at, 0.3, runs=10)) for at, name in enumerate(METHODS)])
    assert (board.edition, {pair.exploratory for pair in board.pairs[FINAL]}) == (1, {True})


def test_a_submission_is_trained_here_with_enough_runs_of_every_group(on_core: OnCore) -> None:
    card = on_core("trpo", normal(3, 0.3))
    whole = trained(card, normal(4, 0.3))
    few = trained(card, normal(4, 0.3, runs=4))
    part = trained(card, {name: values for name, values in normal(4, 0.3).items() if name != GROUPS[0]})
    first = whole.groups[GROUPS[0]]["sequential"]
    others = [
        replace(whole, groups=whole.groups | {GROUPS[0]: {"sequential": log}})
        for log in (replace(first, level="claimed"), replace(first, budget="smoke"))
    ]
    found = [board_of([each]).edition for each in (whole, few, part, *others)]
    assert found == [2, 1, 1, 1, 1]


def test_runs_with_another_budget_are_not_those_of_the_core(on_core: OnCore) -> None:
    card = on_core("a", normal(3, 0.3))
    first = card.groups[GROUPS[0]]["sequential"]
    other = {name: {"sequential": replace(first, budget="1M")} for name in GROUPS}
    core = core_score(replace(card, groups=card.groups | {GROUPS[0]: other[GROUPS[0]]}))
    assert core is not None
    assert (core.missing, core.look, list(core.groups)) == ((GROUPS[0],), 0, list(GROUPS[1:]))
    assert core_score(replace(card, groups=other)) is None


@pytest.mark.parametrize(("protocol", "noted"), [("sequential", 1), ("balanced", 0)])
def test_the_failures_of_the_core_are_those_of_its_sequential_runs(
    on_core: OnCore, protocol: str, noted: int
) -> None:
    failed = {f"hopper-gravity/{protocol}/run0": "too late"}
    made = TrainingSummary(
        attempts=1, date="", version="", commit="", value="", agent="", failed=failed, outdated=False
    )
    card = replace(trained(on_core("new", normal(1, 0.5)), normal(2, 0.5)), training=made)
    core, changed = core_score(card), core_score(replace(card, training=replace(made, outdated=True)))
    assert core is not None
    assert changed is not None
    assert core.notes.count("failed-runs: Runs that failed, and count as the floor: 1.") == noted
    assert changed.notes == (*core.notes, "outdated: Its code was changed since, and waits to be trained.")


def test_steps_that_the_author_claims_are_not_those_of_runs_that_were_trained_here(on_core: OnCore) -> None:
    own = replace(on_core("new", normal(1, 0.5)), steps_counted=False)
    cores = core_score(own), core_score(trained(own, normal(2, 0.5)))
    assert ["steps-claimed" in str(core and core.notes) for core in cores] == [True, False]


@pytest.mark.parametrize(("claimed", "note"), [(0.5, "agree with these"), (0.9, "claim 0.40 more")])
def test_an_authors_own_runs_are_a_claim_beside_them(on_core: OnCore, claimed: float, note: str) -> None:
    exact = dict.fromkeys(GROUPS, tuple(claimed + step for step in (-0.1, -0.05, 0.0, 0.05, 0.1)))
    ours = dict.fromkeys(GROUPS, (0.4, 0.45, 0.5, 0.55, 0.6))
    core = core_score(trained(on_core("new", exact), ours))
    assert core is not None
    assert core.claim is not None
    assert core.claim.difference == pytest.approx(claimed - 0.5)
    assert core.claim.agrees == (claimed == 0.5)
    assert [each for each in core.notes if each.startswith("claim")] == [
        f"claim: The author's own runs {note}."
    ]


def test_the_test_of_a_claim_by_hand() -> None:
    # Pooled variance (2·.01 + 1·.02) / 3 = .0133 in the first group; in the second the floor, .08².
    found = claim_of([((1.1, 1.2, 1.3), (0.9, 1.1)), ((1.0, 1.0), (0.9, 0.9))])
    variances = (0.04 / 3 * (1 / 3 + 1 / 2), 0.08**2 * (1 / 2 + 1 / 2))
    error, df = sum(variances) / 4, sum(variances) ** 2 / (variances[0] ** 2 / 3 + variances[1] ** 2 / 2)
    assert found.difference == pytest.approx(0.15)
    assert found.p_value == pytest.approx(stats.t.sf(0.15 / math.sqrt(error), df))
    assert claim_of([((0.0, 0.1), (1.0, 1.1))]).p_value > 0.5
