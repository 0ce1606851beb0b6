"""Attacks on the truth of results get as far as their rows say, and none above its evidence."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from .attack import LEVELS, NOT_DETECTED, Attack
from .recorders import RECORDERS
from .table import ATTACKS, START, with_table
from .workshop import Workshop

PAGE = Path(__file__).parents[2] / "docs" / "security.md"
QUICK = tuple(attack for attack in ATTACKS if attack.quick)


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Workshop:
    """Honest submissions that all processes of a test run share, and no other run."""
    folder = tmp_path_factory.getbasetemp()
    return Workshop((folder if worker_id == "master" else folder.parent) / "attacks", RECORDERS)


@pytest.fixture
def scratch(workshop: Workshop) -> Iterator[Workshop]:
    yield workshop
    workshop.clear()


def check(attack: Attack, workshop: Workshop) -> None:
    assert attack.play(workshop) == attack.expected


@pytest.mark.parametrize("attack", QUICK, ids=lambda attack: attack.title)
def test_a_quick_attack(attack: Attack, scratch: Workshop) -> None:
    check(attack, scratch)


@pytest.mark.attack
@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.title)
def test_an_attack(attack: Attack, scratch: Workshop) -> None:
    check(attack, scratch)


def test_no_attack_has_a_rank_above_its_evidence() -> None:
    assert [attack.title for attack in ATTACKS if attack.is_above_evidence] == []


def test_what_is_not_detected_says_what_would_detect_it() -> None:
    titles = [attack.title for attack in ATTACKS if attack.stop == NOT_DETECTED and not attack.needed]
    assert titles == []
    assert {attack.rank for attack in ATTACKS} == set(LEVELS)


def test_there_are_at_least_120_different_attacks() -> None:
    assert len({attack.title for attack in ATTACKS}) == len(ATTACKS) >= 120


def test_the_page_has_the_table_of_all_attacks(request: pytest.FixtureRequest) -> None:
    page = PAGE.read_text("utf-8")
    assert START in page
    if request.config.getoption("--write-table", default=False):
        PAGE.write_text(with_table(page), encoding="utf-8", newline="\n")
        return
    assert with_table(page) == page, "Run: make attack"
