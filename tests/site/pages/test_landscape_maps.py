"""The map of a landscape: cells and dots."""

import re
from xml.etree import ElementTree

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.worlds import axes
from gym_extensions.site.pages.landscapes import small

(AXIS,) = axes(group("hopper-gravity"))
POINTS = len(AXIS.points)


def test_a_map_has_cells_where_the_tint_changes_and_a_dot_per_trained_value() -> None:
    shares = [[stage / 5, *[0.1, stage / 5] * 7] for stage in range(6)]
    parts = {
        part.get("class"): part.get("d", "")
        for part in ElementTree.fromstring(small(AXIS, shares, "")).iter()
    }
    assert [parts[f"t{2 * stage}"].count("M") for stage in range(6)] == [8] * 6
    assert parts["t1"] == "M0 30H150", "the most frequent tint is the ground"
    assert parts["t10"].startswith("M0 55H5M")
    drawing = str(small(AXIS, shares, "Run 0"))
    dots = re.findall(r'class="seen" stroke-width="(\S+)" d="(\S[^"]*)"', drawing)
    lengths = [re.findall(r"v(\d+)", way) for _, way in dots]
    assert lengths == [["31", "21", "11", "1"], ["1"] * 5], "4, 3, 2 and 1 small dots, and a large one each"


def test_a_world_without_a_share_is_hatched_and_shares_are_cut_at_zero_and_one() -> None:
    drawing = str(small(AXIS, [[None, -0.5, 1.5, *[0.5] * (POINTS - 3)]], ""))
    assert [drawing.count(f'class="{kind}"') for kind in ("unknown", "t0", "t10", "t5")] == [1, 1, 1, 1]
