"""The editions of the core: statements of the first one are kept or withdrawn without its runs."""

from functools import partial
from pathlib import Path

import msgspec
import pytest

from gym_extensions.catalog.groups import CORES
from gym_extensions.scoring.ranking.boards import CoreBoard
from tools.findings import editions, findings, hypotheses
from tools.findings.editions import ALONE, Statement, outcomes
from tools.findings.hypotheses import Verdict
from tools.findings.tables import FINAL, LEARNED, LOST, NONE, Value

from ..conftest import refused
from ..curation.repositories import git

GROUPS = CORES["core-v1"]


def statement(*of: str, mean: float, verdict: str, metric: str = FINAL, group: str = "") -> Statement:
    return Statement(of, metric, group, Value(mean, mean - 0.1, mean + 0.1), verdict, (10, 20)[: len(of)])


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
    turned = found.kept[0][1]
    assert (turned.of, turned.runs) == (("reset", "trpo"), (20, 10))
    before, after = map(str, found.withdrawn[0])
    assert before == "0.20 (0.10 to 0.30), significant; 10 and 20 runs"
    assert after == "0.02 (−0.08 to 0.12), not significant; 10 and 20 runs"
    assert str(first[3]).endswith("significant; 10 runs")


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
        "without runs": NONE,
    }
    found = editions.statements(board, [], [], values)
    assert {each.of: each.verdict for each in found} == {
        ("more", ALONE): "separated",
        ("less", ALONE): "separated",
        ("same", ALONE): "open",
    }


def test_what_an_edition_states_stays_once_it_is_closed(tmp_path: Path) -> None:
    first, second = (statement("a", "b", mean=mean, verdict="open") for mean in (0.25, 0.5))
    stored = partial(editions.stored, tmp_path / "a.json", Statement)
    assert stored(lambda: [first], is_open=False) == []
    assert stored(lambda: [first], is_open=True) == [first]
    assert stored(lambda: [second, second], is_open=True) == [second, second]
    assert stored(lambda: [first], is_open=False) == [second, second]


def test_verdicts_are_given_once_with_their_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(findings, "ROOT", tmp_path)
    monkeypatch.setattr(findings, "HYPOTHESES", tmp_path / "hypotheses.json")
    given = [Verdict("H1", "p = 0.01", "confirmed")]
    monkeypatch.setattr(
        hypotheses,
        "tested",
        lambda cards, commit: [msgspec.structs.replace(each, commit=commit) for each in given],
    )
    (tmp_path / "submissions").mkdir()
    (tmp_path / "submissions/a").write_text("")
    git(tmp_path, "init", "-q")
    assert findings.verdicts({}, is_early=True) == []
    with refused("not-committed", "submissions/a"):
        findings.verdicts({}, is_early=False)
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "runs")
    (found,) = findings.verdicts({}, is_early=False)
    assert found.commit == git(tmp_path, "rev-parse", "HEAD")
    given.clear()
    assert findings.verdicts({}, is_early=True) == findings.verdicts({}, is_early=False) == [found]


def test_the_committed_statements_are_those_of_the_first_edition() -> None:
    found = editions.stored(findings.FIRST_EDITION, Statement, list, is_open=False)
    on_groups = [each.group for each in found if each.metric == LOST and each.of == ("trpo",)]
    assert sorted(on_groups) == sorted(name.rpartition("-v")[0] for name in GROUPS)
    assert {name for each in found for name in each.of if name.endswith("-tuned")} == set()
    (cloning,) = (
        each for each in found if each.of == ("cloning", "trpo") and (each.metric, each.group) == (FINAL, "")
    )
    assert cloning.direction == ("separated", True)
