"""Labels, names and numbers as readers see them."""

from __future__ import annotations

import msgspec
import pytest
from markupsafe import Markup

from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import text
from gym_extensions.site.text import inline

from .conftest import submission


@pytest.mark.parametrize(
    ("value", "digits", "shown"),
    [
        (0.0, 2, "0.00"),
        (-0.0, 2, "0.00"),
        (-0.004, 2, "0.00"),
        (-0.006, 2, "−0.01"),
        (-153.94, 1, "−153.9"),
        (2690.57, 0, "2691"),
        (0.125, 2, "0.12"),
        (-1.5, 2, "−1.50"),
    ],
)
def test_a_number_has_fixed_digits_and_a_minus_sign(value: float, digits: int, shown: str) -> None:
    assert text.fixed(value, digits) == shown


def test_the_ends_of_an_interval_are_joined_by_a_word() -> None:
    assert text.interval(-0.031, 0.412) == "−0.03 to 0.41"


@pytest.mark.parametrize(
    ("values", "digits"), [([], 2), ([0.3, -1.2], 2), ([9.0, -10.0], 1), ([999.0], 1), ([-1000.0, 2.0], 0)]
)
def test_larger_values_have_fewer_decimals(values: list[float], digits: int) -> None:
    assert text.digits_for(values) == digits


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (True, "yes"),
        (False, "no"),
        (50000, "50\u202f000"),
        (1e-05, "1e−05"),
        ([100, 50, 25], "100, 50, 25"),
        ("Linux-x86_64", "Linux-x86_64"),
    ],
)
def test_a_manifest_value_is_readable(value: object, shown: str) -> None:
    assert text.readable(value) == shown


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
    assert text.task(task_id) == Markup(label)


@pytest.mark.parametrize("version", [0, 1, 10])
def test_a_variation_omits_the_base_name_in_every_version(version: int) -> None:
    base, half = (f"gym_extensions/{name}-v{version}" for name in ("Hopper", "HopperGravityHalf"))
    suffix = f"-v{version}" if version else ""
    assert text.variation(base, (half, base)) == f"Hopper{suffix}"
    assert text.variation(half, (half, base)) == f"Gravity<wbr>Half{suffix}"


def test_a_variation_of_a_group_without_a_common_base_keeps_its_name() -> None:
    assert text.variation("HopperWall-v0", ("HopperWall-v0", "Walker2dWall-v0")) == "Hopper<wbr>Wall"


@pytest.mark.parametrize("ending", ["", "-KnownGoalPosition"])
def test_a_variation_omits_the_parts_that_all_names_begin_and_end_with(ending: str) -> None:
    first, second = (f"State-Based-Navigation-2d-Map0-Goal{goal}{ending}-v0" for goal in (0, 1))
    third = f"State-Based-Navigation-2d-Map1-Goal0{ending}-v0"
    assert text.variation(second, (first, second, third)) == "Map0-<wbr>Goal1"
    assert text.variation(second, (first, second)) == "Goal1"
    assert text.variation(first, (first,)) == text.task(first)


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
    assert text.group(group_id) == Markup(label)


@pytest.mark.parametrize(
    ("long", "shortened"),
    [
        ("short", "short"),
        ("exactly ten", "exactly t…"),
        ("abcdefgh e\N{COMBINING ACUTE ACCENT}x", "abcdefgh…"),
        ("abcdefgh\N{MAN}\N{ZERO WIDTH JOINER}\N{WOMAN}x", "abcdefgh…"),
    ],
)
def test_a_long_text_is_cut_between_characters(long: str, shortened: str) -> None:
    assert text.short(long, 10) == shortened


@pytest.mark.parametrize(
    ("source", "markup"),
    [
        ("plain", "plain"),
        ("a `b` c", "a <code>b</code> c"),
        ("`<b>` & <i>", "<code>&lt;b&gt;</code> &amp; &lt;i&gt;"),
        ("see [the guide](docs/submit.md)", "see the guide"),
        ("[x](javascript:alert(1))", "x)"),
        ("one ` alone", "one ` alone"),
        ("``", "``"),
        ("level *re-evaluated*, 2 * 3 * 4", "level <em>re-evaluated</em>, 2 * 3 * 4"),
        ("`a*b*c`", "<code>a*b*c</code>"),
    ],
)
def test_code_is_marked_and_everything_else_escaped(source: str, markup: str) -> None:
    assert inline(source) == markup


def test_a_budget_has_steps_per_task_and_a_purpose() -> None:
    assert [text.budget(name) for name in ("paper", "1M", "300k", "100k")] == [
        "paper",
        "1M (long)",
        "300k (standard)",
        "100k (quick)",
    ]
    steps = "100\u202f000 training steps per task"
    assert text.budget_steps("100k", "hopper-gravity-v0") == steps
    assert text.budget_steps("paper", "hopper-body-v1") == "25\u202f000\u202f000 training steps per task"


def test_a_missing_file_is_named_after_its_protocol() -> None:
    assert text.missing(["joint.csv", "5 runs"]) == "the protocol “all tasks at once” (joint.csv), 5 runs"


@pytest.mark.parametrize(
    ("level", "label", "is_verified"),
    [
        ("reported", "reported", False),
        ("claimed", "claimed", False),
        ("verified", "verified", True),
        ("reproduced", "reproduced", True),
        (None, "refused", False),
    ],
)
def test_a_level_is_a_word_and_two_of_them_are_verified(
    level: str | None, label: str, is_verified: bool
) -> None:
    card = msgspec.convert({**submission("a", {}), "level": level}, Scorecard)
    assert (text.level(card), text.is_verified(card)) == (label, is_verified)


def test_an_agent_without_task_information_says_none() -> None:
    observes = {"task_in_training": True, "task_in_evaluation": False, "boundaries": True}
    card = msgspec.convert(submission("a", {}, observes=observes), Scorecard)
    assert text.observed(card) == "task label in training, task boundaries"
    blind = msgspec.convert(submission("a", {}, observes=dict.fromkeys(observes, False)), Scorecard)
    assert text.observed(blind) == "none"
