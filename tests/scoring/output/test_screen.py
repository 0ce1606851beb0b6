"""Numbers and verifications on the screen of a submission."""

import msgspec
import pytest

from gym_extensions.scoring.output.screen import console, number, show
from gym_extensions.scoring.scorecard import Scorecard, VerificationSummary


@pytest.mark.parametrize(
    ("value", "digits", "shown"),
    [(None, 3, "–"), (-0.0004, 3, "0.000"), (-0.004, 2, "0.00"), (-0.006, 2, "-0.01"), (12.5, 0, "12")],
)
def test_a_number_has_fixed_digits_and_zero_has_no_sign(value: float | None, digits: int, shown: str) -> None:
    assert number(value, digits) == shown


def test_of_many_verifications_those_that_did_not_pass_and_the_newest_are_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    made: dict[str, object] = {
        "version": "1",
        "value": "",
        "logs": [],
        "runs": 1,
        "current": 1,
        "difference": "",
        "cells": 1,
    }
    made |= {"episodes": 4, "repeated": 4, "p_value": 0.5, "second_p_value": None, "retrained": []}
    found: dict[int, dict[str, object]] = {
        1: {"passed": True},
        2: {"passed": False, "repeated": 3},
        3: {"passed": True},
    }
    found |= {4: {"passed": False, "undecided": "undecided: too slow"}, 5: {"passed": True}}
    parts = [made | changed | {"date": f"2026-01-0{day}"} for day, changed in found.items()]
    summaries = msgspec.convert(parts, tuple[VerificationSummary, ...])
    card = Scorecard(
        name="a", title="A", level="verified", manifest=None, groups={}, suites={}, verifications=summaries
    )
    show(console(), card)
    assert [line.strip() for line in capsys.readouterr().out.splitlines()[1:8]] == [
        "verification of 2026-01-02: 1 run, does not agree on new seeds (p = 0.5), 3 of",
        "4 episodes repeated",
        "verification of 2026-01-04: 1 run, undecided: too slow, 4 of 4 episodes",
        "repeated",
        "verification of 2026-01-05: 1 run, agrees on new seeds (p = 0.5), 4 of 4",
        "episodes repeated",
        "all 5 verifications: 19 of 20 episodes repeated",
    ]
