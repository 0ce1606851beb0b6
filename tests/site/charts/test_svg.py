"""Scales, labels and SVG elements."""

import pytest

from gym_extensions.site.charts.svg import Scale, apart

UNIT = Scale(0.0, 1.0, 0.0, 100.0)


def test_a_scale_maps_its_ends_to_its_ends_and_clips_values_outside() -> None:
    assert [UNIT.at(value) for value in (0.0, 0.25, 1.0, 7.0, -7.0)] == [0.0, 25.0, 100.0, 100.0, 0.0]
    assert [UNIT.contains(value) for value in (0.0, 1.0, 1.01, -0.01)] == [True, True, False, False]


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (0, 1, (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)),
        (-0.3, 1.1, (0.0, 0.5, 1.0)),
        (0, 6000, (0, 1000, 2000, 3000, 4000, 5000, 6000)),
    ],
)
def test_ticks_are_round_and_few(low: float, high: float, ticks: tuple[float, ...]) -> None:
    assert Scale(low, high, 0, 1).ticks() == pytest.approx(ticks)


def test_labels_of_zero_and_one_do_not_collide_on_a_long_scale() -> None:
    assert apart((0.0, 1.0, 8.0), Scale(-0.5, 9.0, 100.0, 10.0)) == [0.0, 8.0]
    assert apart((0.0, 1.0, 1.5), Scale(-0.1, 1.6, 100.0, 10.0)) == [0.0, 1.0, 1.5]
