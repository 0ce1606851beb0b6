"""The drawings: places follow from numbers, and what cannot be seen is said."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.site.charts import strip_plot as charts
from gym_extensions.site.charts.scale import Axis, around

UNIT = Axis(0.0, 1.0, 0.0, 100.0)
FIVE = MetricValue(0.5, 0.4, 0.6, (0.4, 0.45, 0.5, 0.55, 0.6))


def parts(svg: str, kind: str) -> list[ElementTree.Element]:
    """The drawing's elements whose class holds the word."""
    return [item for item in ElementTree.fromstring(svg).iter() if kind in item.get("class", "").split()]


def test_an_axis_maps_ends_to_ends_and_holds_the_rest_inside() -> None:
    assert [UNIT.at(value) for value in (0.0, 0.25, 1.0, 7.0, -7.0)] == [0.0, 25.0, 100.0, 100.0, 0.0]
    assert [UNIT.holds(value) for value in (0.0, 1.0, 1.01, -0.01)] == [True, True, False, False]


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (0, 1, (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)),
        (-0.3, 1.1, (0.0, 0.5, 1.0)),
        (0, 6000, (0, 1000, 2000, 3000, 4000, 5000, 6000)),
    ],
)
def test_ticks_are_round_and_few(low: float, high: float, ticks: tuple[float, ...]) -> None:
    assert Axis(low, high, 0, 1).ticks() == pytest.approx(ticks)


def test_a_scale_always_shows_the_floor_and_the_reference() -> None:
    axis = around([0.4, 0.5], 0, 100)
    assert axis.holds(0.0)
    assert axis.holds(1.0)


def test_a_scale_of_one_value_has_a_width() -> None:
    assert around([3.0], 0, 100, always=()).at(3.0) == pytest.approx(50.0)


def test_a_strip_draws_a_dot_for_each_run_the_mean_and_the_interval() -> None:
    svg = charts.strip(FIVE, UNIT)
    assert [dot.get("cx") for dot in parts(svg, "run")] == ["40.0", "45.0", "50.0", "55.0", "60.0"]
    assert [dot.get("cx") for dot in parts(svg, "mean")] == ["50.0"]
    bar = parts(svg, "interval")[0]
    assert (bar.get("x1"), bar.get("x2")) == ("40.0", "60.0")
    assert not parts(svg, "beyond")


def test_an_interval_beyond_the_scale_ends_in_an_arrow_on_that_side() -> None:
    arrows = parts(charts.strip(MetricValue(0.5, -0.5, 0.8, (0.4, 0.6)), UNIT), "beyond")
    assert [arrow.get("points") for arrow in arrows] == ["-7.0,11.0 0.0,6.0 0.0,16.0"]


def test_one_run_has_a_mean_and_no_interval() -> None:
    svg = charts.strip(MetricValue(0.5, None, None, (0.5,)), UNIT)
    assert not parts(svg, "interval")
    assert "one run, no interval" in svg


def test_an_estimate_without_a_value_is_not_drawn_at_zero() -> None:
    assert charts.strip(MetricValue(why="all tasks are open"), UNIT) == ""


@pytest.mark.parametrize(("after", "kind"), [(0.2, "loss"), (0.8, "gain"), (0.502, "same")])
def test_what_was_forgotten_leans_left_and_is_called_a_loss(after: float, kind: str) -> None:
    svg = charts.slope(MetricValue(0.5, None, None, (0.5,)), MetricValue(after, None, None, (after,)), UNIT)
    line = parts(svg, "join")[0]
    assert line.get("class") == f"join {kind}"
    assert (line.get("x1"), line.get("x2")) == ("50.0", f"{after * 100:.1f}")


def test_a_drawing_is_told_in_words() -> None:
    label = ElementTree.fromstring(charts.slope(FIVE, FIVE, UNIT)).get("aria-label")
    half = "0.50, 95 % interval 0.40 to 0.60"
    assert label == f"learning performance {half}; final performance {half}"


def test_a_ruler_names_floor_and_reference_even_on_a_long_scale() -> None:
    texts = re.findall(r">([^<]+)</text>", charts.ruler(Axis(-1.0, 30.0, 12, 268)))
    assert texts[:1] == ["0"]
    assert "1" in texts


def test_hostile_text_in_a_label_stays_text() -> None:
    svg = charts.panel([[(0, 0), (1, 1)]], UNIT, UNIT, '"><script>alert(1)</script>')
    assert "<script" not in svg
    assert ElementTree.fromstring(svg).get("aria-label") == '"><script>alert(1)</script>'
