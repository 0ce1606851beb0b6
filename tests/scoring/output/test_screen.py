"""Numbers on the screen of a submission."""

import pytest

from gym_extensions.scoring.output.screen import number


@pytest.mark.parametrize(
    ("value", "digits", "shown"),
    [(None, 3, "–"), (-0.0004, 3, "0.000"), (-0.004, 2, "0.00"), (-0.006, 2, "-0.01"), (12.5, 0, "12")],
)
def test_a_number_has_fixed_digits_and_zero_has_no_sign(value: float | None, digits: int, shown: str) -> None:
    assert number(value, digits) == shown
