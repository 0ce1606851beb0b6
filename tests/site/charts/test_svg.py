"""Labels of a vertical scale do not overlap."""

from __future__ import annotations

from gym_extensions.site.charts.scale import Scale
from gym_extensions.site.charts.svg import apart, points


def test_labels_of_zero_and_one_do_not_collide_on_a_long_scale() -> None:
    assert apart((0.0, 1.0, 8.0), Scale(-0.5, 9.0, 100.0, 10.0)) == [0.0, 8.0]
    assert apart((0.0, 1.0, 1.5), Scale(-0.1, 1.6, 100.0, 10.0)) == [0.0, 1.0, 1.5]


def test_a_level_outside_the_scale_has_no_label() -> None:
    assert apart((0.0, 5.0), Scale(0.0, 1.0, 100.0, 10.0)) == [0.0]


def test_points_are_clipped_to_the_scales() -> None:
    unit = Scale(0.0, 1.0, 0.0, 100.0)
    assert points([(0.0, -1.0), (0.5, 0.25), (2.0, 1.0)], unit, unit) == "0.0,0.0 50.0,25.0 100.0,100.0"
