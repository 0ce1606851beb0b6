"""Line charts: one thin line per run, a bold mean, and an escaped label."""

from __future__ import annotations

from xml.etree import ElementTree

from gym_extensions.site.charts.line_chart import line_chart
from gym_extensions.site.charts.scale import Scale

X = Scale(0.0, 1.0, 0.0, 100.0)
Y = Scale(0.0, 1.0, 100.0, 0.0)


def test_lines_levels_and_shading_have_the_coordinates_of_their_values() -> None:
    mean = [(0.0, 0.0), (0.5, 1.0)]
    svg = ElementTree.fromstring(line_chart([mean, mean], X, Y, "", bold=mean, since=0.5, levels=[1.0]))
    assert [line.get("points") for line in svg.iter("polyline")] == ["0.0,100.0 50.0,0.0"]
    assert [(line.get("transform"), line.get("d")) for line in svg.iter("path")] == [
        ("scale(0.5)", "M0 200l100-200")
    ] * 2
    assert [(dot.get("class"), dot.get("cx"), dot.get("cy")) for dot in svg.iter("circle")] == [
        ("stop", "0.0", "100.0"),
        ("at", "50.0", "0.0"),
    ]
    assert [area.get("width") for area in svg.iter("rect")] == ["50.0"]
    assert [level.text for level in svg.iter("text")] == ["1"]


def test_markup_in_a_label_is_escaped() -> None:
    svg = line_chart([[(0, 0), (1, 1)]], X, Y, '"><script>alert(1)</script>')
    assert "<script" not in svg
    assert ElementTree.fromstring(svg).get("aria-label") == '"><script>alert(1)</script>'
