"""Line charts and performance profiles."""

import re
from typing import Any
from xml.etree import ElementTree

import pytest

from gym_extensions.site.charts import line_charts
from gym_extensions.site.charts.svg import Scale
from gym_extensions.site.submission_results import results_of

from ..browser import Reader, files, typed
from ..conftest import missing, scores_of

X = Scale(0.0, 1.0, 0.0, 100.0)
Y = Scale(0.0, 1.0, 100.0, 0.0)


def test_lines_levels_and_shading_have_the_coordinates_of_their_values() -> None:
    mean = [(0.0, 0.0), (0.5, 1.0)]
    svg = ElementTree.fromstring(
        line_charts.line_chart([mean, mean], X, Y, "", bold=mean, since=0.5, levels=[1.0])
    )
    assert [(line.get("class"), line.get("d")) for line in svg.iter("path")] == [
        ("level", "M0 0H100"),
        ("thin", "M0 200l100-200"),
        ("thin", "M0 200l100-200"),
        ("bold", "M0 200l100-200"),
        ("stops", "M0 200h0m100-200h0"),
    ]
    assert [(dot.get("cx"), dot.get("cy")) for dot in svg.iter("circle")] == [("50", "0")]
    assert [area.get("width") for area in svg.iter("rect")] == ["50"]
    assert [level.text for level in svg.iter("text")] == ["1"]


TAUS, SHARES = (-0.5, 0.0, 0.5, 1.0, 1.5, 2.0), (1.0, 1.0, 0.5, 0.25, 0.0, 0.0)
OPEN = "Every task of this group is open: no expert is known that is clearly better than the floor."


def test_a_profile_goes_through_the_points_of_the_document(document: dict[str, Any]) -> None:
    scores_of(document).update(profile={"tau": TAUS, "fraction": SHARES}, iqm=0.4)
    (result, *_) = results_of(typed(document).submissions[0].groups)
    drawing = ElementTree.fromstring(line_charts.profile(result))
    assert [polyline.get("points") for polyline in drawing.findall("polyline")] == [
        "40.0,24.0 106.4,24.0 172.8,94.0 239.2,129.0 305.6,164.0 372.0,164.0"
    ]
    words = "above 0: 100 %, above 0.5: 50 %, above 1: 25 %, above 2: 0 %"
    assert str(drawing.get("aria-label")).replace("\u202f", " ") == words
    texts = [element.text for element in drawing]
    for label in ("0\u202f%", "100\u202f%", "−0.5", "0", "2", "share of runs and tasks above the score"):
        assert label in texts


def test_without_a_profile_the_page_says_why(document: dict[str, Any]) -> None:
    document["submissions"][0]["groups"]["hopper-gravity-v0"].pop("single")
    scores_of(document).update(profile=None, iqm=None)
    scores_of(document)["metrics"]["final_performance"] = missing(OPEN)
    page = dict(files(document))["submissions/agile.html"]
    assert '<svg class="profile"' not in page
    assert f"No performance profile. {OPEN}" in Reader(page).text
    scores_of(document)["metrics"] = dict.fromkeys(scores_of(document)["metrics"], missing(OPEN))
    page = dict(files(document))["submissions/agile.html"]
    assert f"No metrics. {OPEN} There is no performance profile either." in Reader(page).text


@pytest.mark.parametrize(("points", "drawn"), [(80, 80), (81, 41), (700, 78)])
def test_a_long_curve_is_drawn_as_means_of_neighbours(
    document: dict[str, Any], points: int, drawn: int
) -> None:
    line = [[at, float(at % 2)] for at in range(points)]
    scores_of(document)["curves"] = [{"run": 0, "task": "gym_extensions/Hopper-v0", "points": line}]
    (result, *_) = results_of(typed(document).submissions[0].groups)
    ((_, _, drawing),) = line_charts.curves(result)
    (way,) = re.findall(r'class="thin" d="M\d+ -?\d+l([^"]*)"', drawing)
    assert len(re.findall(r"-?\d+", way)) == 2 * (drawn - 1)


def test_the_first_return_of_a_curve_is_beside_the_floor(document: dict[str, Any]) -> None:
    """The mean over runs of the first point; a level at the floor, which may be below all returns."""
    curve = {"task": "gym_extensions/Hopper-v0", "points": [[250, 410.0], [500, 600.0]]}
    scores_of(document)["curves"] = [curve | {"run": 0}, curve | {"run": 1, "points": [[250, 420.0]]}]
    scores_of(document)["reference"]["gym_extensions/Hopper-v0"]["floor"] = 146.0
    (result, *_) = results_of(typed(document).submissions[0].groups)
    ((_, facts, drawing),) = line_charts.curves(result)
    assert facts == "500 steps, first 415, floor 146"
    assert [each.text for each in ElementTree.fromstring(drawing).iter("text")] == ["146", "600"]
    scores_of(document)["reference"]["gym_extensions/Hopper-v0"]["floor"] = None
    (result, *_) = results_of(typed(document).submissions[0].groups)
    ((_, facts, _),) = line_charts.curves(result)
    assert facts == "500 steps, first 415"
