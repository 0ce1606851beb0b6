"""Names of tasks and groups in every version."""

from __future__ import annotations

import pytest
from markupsafe import Markup

from gym_extensions.site.text import names


@pytest.mark.parametrize(
    ("task_id", "label"),
    [
        ("gym_extensions/HopperWall-v0", "Hopper<wbr>Wall"),
        ("gym_extensions/HopperWall-v1", "Hopper<wbr>Wall-v1"),
        ("gym_extensions/HopperWall-v12", "Hopper<wbr>Wall-v12"),
        ("HopperWall", "Hopper<wbr>Wall"),
        ("<b>-v0", "&lt;b&gt;"),
    ],
)
def test_a_task_has_no_namespace_and_a_version_from_1_on(task_id: str, label: str) -> None:
    assert names.task(task_id) == Markup(label)


@pytest.mark.parametrize("version", [0, 1, 10])
def test_a_variation_omits_the_base_name_in_every_version(version: int) -> None:
    base, half = (f"gym_extensions/{name}-v{version}" for name in ("Hopper", "HopperGravityHalf"))
    suffix = f"-v{version}" if version else ""
    assert names.variation(base, (half, base)) == f"Hopper{suffix}"
    assert names.variation(half, (half, base)) == f"Gravity<wbr>Half{suffix}"


def test_a_variation_of_a_group_without_a_common_base_keeps_its_name() -> None:
    assert names.variation("HopperWall-v0", ("HopperWall-v0", "Walker2dWall-v0")) == "Hopper<wbr>Wall"


@pytest.mark.parametrize("ending", ["", "-KnownGoalPosition"])
def test_a_variation_omits_the_parts_that_all_names_begin_and_end_with(ending: str) -> None:
    first, second = (f"State-Based-Navigation-2d-Map0-Goal{goal}{ending}-v0" for goal in (0, 1))
    third = f"State-Based-Navigation-2d-Map1-Goal0{ending}-v0"
    assert names.variation(second, (first, second, third)) == "Map0-<wbr>Goal1"
    assert names.variation(second, (first, second)) == "Goal1"
    assert names.variation(first, (first,)) == names.task(first)


@pytest.mark.parametrize(
    ("group_id", "label"),
    [
        ("hopper-gravity-v0", 'hopper-gravity<span class="version">-v0</span>'),
        ("hopper-gravity-v11", 'hopper-gravity<span class="version">-v11</span>'),
        ("maze-vision", "maze-vision"),
        ("gravity", 'gravity <span class="version">suite, mean of 4 groups</span>'),
    ],
)
def test_a_group_shows_its_version_and_a_suite_its_size(group_id: str, label: str) -> None:
    assert names.group(group_id) == Markup(label)


@pytest.mark.parametrize(
    ("text", "shortened"),
    [
        ("short", "short"),
        ("exactly ten", "exactly t…"),
        ("abcdefgh e\N{COMBINING ACUTE ACCENT}x", "abcdefgh…"),
        ("abcdefgh\N{MAN}\N{ZERO WIDTH JOINER}\N{WOMAN}x", "abcdefgh…"),
    ],
)
def test_a_long_text_is_cut_between_characters(text: str, shortened: str) -> None:
    assert names.short(text, 10) == shortened
