"""The editions of the core: statements of the first one are kept or withdrawn without its runs."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from jinja2 import Environment, FileSystemLoader

from gym_extensions.catalog.groups import CORES
from gym_extensions.scoring import score_folder
from gym_extensions.scoring.ranking.boards import CoreBoard
from tools.findings import editions, findings
from tools.findings.editions import ALONE, Statement, outcomes
from tools.findings.orders import turned
from tools.findings.tables import FINAL, LEARNED, LOST, Against, Method, Value

from ..conftest import MANIFEST

GROUPS = CORES["core-v1"]


def statement(*of: str, mean: float, verdict: str, metric: str = FINAL, group: str = "") -> Statement:
    return Statement(of, metric, group, Value(mean, mean - 0.1, mean + 0.1), verdict)


def test_a_statement_is_withdrawn_if_its_verdict_or_its_direction_is_another_one() -> None:
    first = [
        statement("cloning", "trpo", mean=0.2, verdict="separated"),
        statement("ppo", "trpo", mean=0.2, verdict="separated"),
        statement("l2", "trpo", mean=0.0, verdict="open"),
        statement("trpo", mean=0.1, verdict="separated", metric=LOST, group="hopper-wall"),
        statement("reset", "trpo", mean=-0.2, verdict="separated"),
        statement("trpo", mean=0.4, verdict="separated", metric=LOST, group="hopper-gravity"),
    ]
    second = [
        statement("cloning-tuned", "trpo", mean=0.02, verdict="open"),
        statement("ppo-tuned", "trpo", mean=-0.2, verdict="separated"),
        statement("l2-tuned", "trpo", mean=0.0, verdict="equivalent"),
        statement("trpo", mean=0.1, verdict="open", metric=LOST, group="hopper-wall"),
        statement("trpo", "reset", mean=0.3, verdict="separated"),
        statement("trpo", mean=0.3, verdict="separated", metric=LOST, group="hopper-gravity"),
    ]
    found = outcomes(first, second)
    assert [before for before, _ in found.withdrawn] == first[:4]
    assert [before for before, _ in found.kept] == first[4:]
    assert found.kept[0][1].of == ("reset", "trpo")
    before, after = map(str, found.withdrawn[0])
    assert (before, after) == ("0.20 (0.10 to 0.30), significant", "0.02 (−0.08 to 0.12), not significant")


def test_what_is_not_compared_again_is_neither_kept_nor_withdrawn() -> None:
    little = statement("ppo", ALONE, mean=-0.2, verdict="separated", metric=LEARNED)
    both = statement("l2", "trpo", mean=0.0, verdict="open")
    assert outcomes([little, both], []) == ([], [], [little], 0)
    again = statement("l2-tuned", "trpo", mean=0.1, verdict="open")
    assert outcomes([both], [again]) == ([], [], [], 1)
    assert little.subject == "`ppo` − each task alone, learned"


def test_what_was_learned_minus_each_task_alone_is_significant_by_its_interval() -> None:
    board = CoreBoard(
        edition=1, pairs={}, lists=(), suite="", groups=(), budget="", looks=(), levels=(), margin=0.05
    )
    values = {
        "more": Value(0.1, 0.05, 0.15),
        "less": Value(-0.1, -0.15, -0.05),
        "same": Value(0.0, -0.1, 0.1),
    }
    found = editions.statements(board, [], [], values)
    assert [each.verdict for each in found] == ["separated", "separated", "open"]


def test_statements_are_stored_with_six_decimals(tmp_path: Path) -> None:
    stored = statement("a", "b", mean=1 / 3, verdict="open")
    editions.write_statements(tmp_path / "a.json", [stored])
    (found,) = editions.read_statements(tmp_path / "a.json")
    assert found.value[0] == 0.333333
    assert (found.of, found.verdict) == (stored.of, stored.verdict)


def test_the_committed_statements_are_those_of_the_first_edition() -> None:
    found = editions.read_statements(findings.FIRST_EDITION)
    on_groups = [each.group for each in found if each.metric == LOST and each.of == ("trpo",)]
    assert sorted(on_groups) == sorted(name.rpartition("-v")[0] for name in GROUPS)
    assert {name for each in found for name in each.of if name.endswith("-tuned")} == set()
    (cloning,) = (
        each for each in found if each.of == ("cloning", "trpo") and (each.metric, each.group) == (FINAL, "")
    )
    assert cloning.direction == ("separated", True)


@pytest.mark.usefixtures("known")
def test_a_group_has_the_runs_that_were_trained_here(make_submission: Callable[..., Path]) -> None:
    folder = make_submission(name="a", runs=tuple(range(5)), manifest=MANIFEST.replace("smoke", "300k"))
    card = score_folder(folder)
    log = card.groups["hopper-gravity-v0"]["sequential"]
    here = replace(log, level="trained here")
    own = {name: {"sequential": log, "single": log} for name in (*GROUPS, "pusher-v0")}
    card = replace(card, groups=own, trained=dict.fromkeys(GROUPS, here))
    groups = editions.as_compared(card).groups
    assert {groups[name]["sequential"].level for name in GROUPS} == {"trained here"}
    assert groups["pusher-v0"] == own["pusher-v0"]
    assert groups[GROUPS[0]]["single"] is log
    few = replace(card, trained={GROUPS[0]: here})
    assert editions.as_compared(few).groups == own


@pytest.mark.usefixtures("known")
def test_runs_of_an_author_are_compared_with_his_own_alone(make_submission: Callable[..., Path]) -> None:
    """As those in descending order, which are of the first edition."""
    card = score_folder(make_submission(name="a", runs=(0, 1), protocols=("sequential", "descending")))
    (group,) = card.groups
    assert len(turned([editions.of_author(card)])) == 1
    here = replace(card.groups[group]["sequential"], level="trained here")
    card = replace(card, groups={group: card.groups[group] | {"sequential": here}, "b": {"sequential": here}})
    assert {name: list(logs) for name, logs in editions.of_author(card).groups.items()} == {
        group: ["descending"]
    }
    assert turned([editions.of_author(card)]) == []


@pytest.mark.parametrize("is_learned_score", [True, False])
def test_what_snapshots_are_compared_with_does_not_depend_on_how_they_were_made(
    is_learned_score: bool,
) -> None:
    text = (Path(findings.__file__).parent / "page.md.jinja").read_text(encoding="utf-8")
    part = text[text.index("`snapshots` is fine-tuning with") : text.index("### Where cloning gains")]
    environment = Environment(loader=FileSystemLoader("."), trim_blocks=True)
    pair = Against(Value(0.2, 0.1, 0.3), "separated", True, 0.01)
    row = pd.Series({"name": "packnet-tuned", "observes_task": True})
    page = environment.from_string(part.rpartition("{% if gains")[0]).render(
        methods=[Method(row, {})],
        pair_of=lambda *_: pair,
        fmt="{:.2f}".format,
        edition=2,
        is_learned_score=is_learned_score,
        cloning="cloning-tuned",
        packnet="packnet-tuned",
        differences={"snapshots": "", "alone": ""},
    )
    assert ("to the last bit" in page) == is_learned_score
    assert "It ends 0.20 above `packnet-tuned`" in page
    assert "`snapshots` minus `cloning-tuned` is" in page
