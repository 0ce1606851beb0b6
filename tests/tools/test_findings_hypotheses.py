"""The hypotheses of the second edition: one direction each, and open unless the test of the core decides."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.catalog.groups import CORES
from gym_extensions.metrics.formulas import BY_NAME
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.group_score import GroupScore
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.ranking.boards import CoreBoard, CorePair
from gym_extensions.scoring.ranking.core_board import PLANNED, core_board
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import core_score
from tools.findings import hypotheses
from tools.findings.tables import FINAL, LOST, Value

from ..conftest import MANIFEST, Write

PLAN = Path(hypotheses.__file__).parents[2] / "docs/findings/plan.md"
GROUPS = CORES["core-v1"]


def pair(first: str, second: str, mean: float, half: float, verdict: str) -> CorePair:
    ends = {"mean": mean, "low": mean - half, "high": mean + half}
    facts = {"look": 10, "paired": False, "p_value": 0.01, "exploratory": False, "next_look": None}
    return CorePair(first=first, second=second, verdict=verdict, **ends, **facts)  # type: ignore[arg-type]


def board(*pairs: CorePair, edition: int = 2) -> CoreBoard:
    """A board with these pairs on both metrics; the difference of forgetting has the other sign."""
    lost = [pair(each.second, each.first, each.mean, 0.01, each.verdict) for each in pairs]
    nothing = {
        "suite": "",
        "groups": (),
        "budget": "",
        "looks": (),
        "levels": (),
        "margin": 0.05,
        "lists": (),
    }
    made = {FINAL: tuple(pairs), LOST: tuple(lost)}
    return CoreBoard(edition=edition, pairs=made, references=(), variants=(), **nothing)  # type: ignore[arg-type]


def verdict(made: CoreBoard, name: str) -> str:
    (found,) = (each for each in hypotheses.verdicts(made, {}) if each.name == name)
    return found.verdict


@pytest.mark.parametrize(
    ("mean", "kind", "expected"),
    [(0.2, "separated", "confirmed"), (-0.2, "separated", "contradicted"), (0.2, "open", "open")],
)
def test_a_pair_is_confirmed_in_the_stated_direction_alone(mean: float, kind: str, expected: str) -> None:
    made = board(pair("cloning-tuned", "trpo", mean, 0.1, kind))
    assert (verdict(made, "H1"), verdict(made, "H2")) == (expected, expected)
    turned = board(pair("trpo", "cloning-tuned", -mean, 0.1, kind))
    assert verdict(turned, "H1") == expected
    assert verdict(made, "H5") == "open", "these two are not compared"


def test_the_methods_are_those_of_the_second_edition() -> None:
    assert verdict(board(pair("cloning", "trpo", 0.2, 0.1, "separated")), "H1") == "open"
    assert verdict(board(pair("snapshots", "packnet-tuned", 0.2, 0.1, "separated")), "H5") == "confirmed"


def penalties(**highest: float) -> CoreBoard:
    """The penalties minus fine-tuning, with these upper limits."""
    names = {"l2": "l2-tuned", "l2_init": "l2-init-tuned", "online_ewc": "online-ewc-tuned"}
    return board(*(pair(names[key], "trpo", high - 0.04, 0.04, "open") for key, high in highest.items()))


def test_no_penalty_is_better_if_all_upper_limits_are_low() -> None:
    assert verdict(penalties(l2=0.05, l2_init=0.09, online_ewc=0.0), "H8") == "confirmed"
    assert verdict(penalties(l2=0.05, l2_init=0.11, online_ewc=0.0), "H8") == "open"
    assert verdict(penalties(l2=0.05, l2_init=0.09), "H8") == "open", "one is not compared"
    better = board(pair("l2-tuned", "trpo", 0.2, 0.1, "separated"))
    assert verdict(better, "H8") == "contradicted"
    worse = board(*(pair(name, "trpo", -0.2, 0.1, "separated") for name in ("l2-tuned", "l2-init-tuned")))
    assert verdict(worse, "H8") == "open"


def test_forgetting_is_tested_group_by_group_over_all_groups() -> None:
    clear, none, gained = (0.5, 0.52, 0.48, 0.51), (0.1, -0.1, 0.12, -0.12), (-0.5, -0.52, -0.48, -0.51)
    lost = dict.fromkeys(GROUPS, clear) | {GROUPS[0]: none, GROUPS[1]: gained}
    found = {each.found.partition(":")[0]: each.verdict for each in hypotheses.forgetting(lost)}
    names = [group.rpartition("-v")[0] for group in GROUPS]
    assert len(found) == 6
    assert "hopper-body" not in found
    assert (found[names[0]], found[names[1]]) == ("open", "contradicted")
    assert {found[name] for name in names[2:] if name in found} == {"confirmed"}
    (lacking,) = hypotheses.forgetting({GROUPS[0]: clear})
    assert lacking.verdict == "open"


Trained = Callable[..., Scorecard]


@pytest.fixture
def trained(make_submission: Write, known: object) -> Trained:
    """Makes a submission that was trained here: every metric has these values in runs 0, 1, … of a group."""
    folder = make_submission(runs=tuple(range(5)), manifest=MANIFEST.replace("smoke", "300k"))
    card = score_folder(folder)
    log = card.groups["hopper-gravity-v0"]["sequential"]

    def make(name: str, values: tuple[float, ...], alone: tuple[float, ...] = ()) -> Scorecard:
        def of(log: GroupScore, values: tuple[float, ...]) -> GroupScore:
            metrics = dict.fromkeys(BY_NAME, MetricValue(mean=0.0, runs=values))
            made = replace(log, metrics=metrics, level="trained here", episode_sketches=())
            matrix = log.return_matrix[:1] * len(values)
            return replace(made, runs=tuple(range(len(values))), return_matrix=matrix)

        logs = {"sequential": of(log, values)} | ({"single": of(log, alone)} if alone else {})
        made = replace(card, name=name, groups=dict.fromkeys(GROUPS, logs))
        return replace(made, core=core_score(made))

    return make


NONE, CLEAR = (0.1, -0.1, 0.12, -0.12, 0.0) * 2, (0.5, 0.52, 0.48, 0.51, 0.5) * 2


def test_runs_after_the_first_ten_change_no_verdict(trained: Trained) -> None:
    """The hypotheses are tested once."""

    def found(later: tuple[float, ...]) -> list[hypotheses.Verdict]:
        cards = trained("trpo", NONE + later), trained("reset", NONE + NONE)
        return hypotheses.tested({each.name: each for each in cards})

    h3, *h7 = (each for each in found(CLEAR) if each.name in ("H3", "H7"))
    assert (h3.verdict, len(h7), {each.verdict for each in h7}) == ("open", 6, {"open"})
    assert found(CLEAR) == found(NONE)


def test_a_pair_is_tested_as_on_the_board_where_a_method_learned_little(trained: Trained) -> None:
    """Such a method is not in the family of forgetting. It takes each task alone to know it."""
    wide = (0.0, 1.0, 0.4, 0.7, 0.4) * 2
    low = tuple(value - 0.3 for value in wide)
    cards = [trained("trpo", wide, alone=wide), trained("cloning-tuned", wide[::-1]), trained("reset", low)]
    board = core_board(cards)
    assert board is not None
    (pair,) = board.pairs[LOST]
    assert len(board.pairs[FINAL]) == 3, "its interval is that of three pairs, and wider"
    (h2,) = (each for each in hypotheses.tested({each.name: each for each in cards}) if each.name == "H2")
    assert str(Value(pair.mean, pair.low, pair.high)) in h2.found


def test_every_hypothesis_of_the_plan_has_a_verdict_on_the_pairs_that_it_names() -> None:
    rows = [line for line in PLAN.read_text("utf-8").splitlines() if line.startswith("| H")]
    stated = {row.split("|")[1].strip(): set(re.findall(r"`([\w-]+)`", row)) for row in rows}
    assert list(stated) == [f"H{number}" for number in range(1, 9)]
    assert [each.name for each in hypotheses.verdicts(board(), {})] == list(stated)
    planned: dict[str, set[str]] = {"H7": {"trpo"}}
    for name, first, second, _ in PLANNED:
        planned.setdefault(name, set()).update((first.removesuffix("-tuned"), second.removesuffix("-tuned")))
    assert planned == stated
