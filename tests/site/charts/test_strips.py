"""Strip plots: coordinates follow from numbers, and labels describe the drawing."""

from xml.etree import ElementTree

import pytest

from gym_extensions.metrics.values import MetricValue
from gym_extensions.site.charts.strips import dumbbell, metric_scale, strip
from gym_extensions.site.charts.svg import Scale

UNIT = Scale(0.0, 1.0, 0.0, 100.0)
FIVE_RUNS = MetricValue(0.5, 0.4, 0.6, (0.4, 0.45, 0.5, 0.55, 0.6))


def elements(svg: str, kind: str) -> list[ElementTree.Element]:
    """The elements of a drawing with that class."""
    return [item for item in ElementTree.fromstring(svg).iter() if kind in item.get("class", "").split()]


def test_a_strip_has_a_dot_per_run_the_mean_and_the_interval() -> None:
    svg = strip(FIVE_RUNS, UNIT)
    assert [dot.get("cx") for dot in elements(svg, "run")] == ["40", "45", "50", "55", "60"]
    assert [dot.get("cx") for dot in elements(svg, "mean")] == ["50"]
    bar = elements(svg, "interval")[0]
    assert (bar.get("x1"), bar.get("x2")) == ("40", "60")
    assert not elements(svg, "beyond")


def test_an_interval_beyond_the_scale_ends_in_an_arrow() -> None:
    arrows = elements(strip(MetricValue(0.5, -0.5, 0.8, (0.4, 0.6)), UNIT), "beyond")
    assert [arrow.get("points") for arrow in arrows] == ["-7,11 0,6 0,16"]


def test_one_run_has_a_mean_and_no_interval() -> None:
    svg = strip(MetricValue(0.5, None, None, (0.5,)), UNIT)
    assert not elements(svg, "interval")
    assert "one run, no interval" in svg


def test_a_shared_scale_contains_means_and_runs_but_not_wide_intervals() -> None:
    scale = metric_scale([MetricValue(0.5, -9.0, 9.0, (0.2, 2.0)), MetricValue(why="missing")])
    assert (scale.low, scale.high) == pytest.approx((-0.12, 2.12))


@pytest.mark.parametrize(("after", "kind"), [(0.2, "loss"), (0.8, "gain"), (0.502, "same")])
def test_a_disc_to_the_left_of_its_ring_is_a_loss(after: float, kind: str) -> None:
    svg = dumbbell(MetricValue(0.5, None, None, (0.5,)), MetricValue(after, None, None, (after,)), UNIT)
    line = elements(svg, "join")[0]
    assert line.get("class") == f"join {kind}"
    assert (line.get("x1"), line.get("x2")) == ("50", f"{after * 100:g}")
    assert f"; at the end {after:.2f}, one run" in str(ElementTree.fromstring(svg).get("aria-label"))
