"""Labels, names and numbers as readers see them."""

import pytest

from gym_extensions.site import text

NUMBERS = [
    (-0.0, 2, "0.00"),
    (-0.004, 2, "0.00"),
    (-0.006, 2, "−0.01"),
    (-153.94, 1, "−153.9"),
    (0.125, 2, "0.12"),
]


@pytest.mark.parametrize(("value", "digits", "shown"), NUMBERS)
def test_a_number_has_fixed_digits_and_a_minus_sign(value: float, digits: int, shown: str) -> None:
    assert text.fixed(value, digits) == shown


@pytest.mark.parametrize(
    ("value", "said"), [(0.0004, "p < 0.001"), (0.0123, "p = 0.012"), (0.0496, "p = 0.0496")]
)
def test_a_p_value_has_four_digits_about_the_level(value: float, said: str) -> None:
    assert text.p_equals(value) == said


@pytest.mark.parametrize(
    ("task_id", "label"),
    [
        ("gym_extensions/HopperWall-v0", "Hopper<wbr>Wall"),
        ("gym_extensions/HopperWall-v1", "Hopper<wbr>Wall-v1"),
        ("<b>-v0", "&lt;b&gt;"),
    ],
)
def test_a_task_has_no_namespace_and_a_version_from_1_on(task_id: str, label: str) -> None:
    assert text.task(task_id) == label


def test_a_variation_omits_the_base_name_in_every_version() -> None:
    for version, suffix in ((0, ""), (1, "-v1"), (10, "-v10")):
        base, half = (f"gym_extensions/{name}-v{version}" for name in ("Hopper", "HopperGravityHalf"))
        assert text.variation(base, (half, base)) == f"Hopper{suffix}"
        assert text.variation(half, (half, base)) == f"Gravity<wbr>Half{suffix}"
    longer = "Pendulum-v1.steps-100"
    assert text.variation(longer, ("Pendulum-v1", longer)) == "v1.steps-100"


def test_a_variation_omits_the_parts_that_all_names_begin_and_end_with() -> None:
    for ending in ("", "-KnownGoalPosition"):
        first, second, third = (
            f"State-Based-Navigation-2d-{goal}{ending}-v0"
            for goal in ("Map0-Goal0", "Map0-Goal1", "Map1-Goal0")
        )
        assert text.variation(second, (first, second, third)) == "Map0-<wbr>Goal1"
        assert text.variation(second, (first, second)) == "Goal1"
        assert text.variation(first, (first,)) == text.task(first)


@pytest.mark.parametrize(
    ("group_id", "label"),
    [
        ("hopper-gravity-v11", 'hopper-gravity<span class="version">-v11</span>'),
        ("maze-vision", "maze-vision"),
        ("gravity", 'gravity <span class="version">suite, mean of 4 groups</span>'),
    ],
)
def test_a_group_shows_its_version_and_a_suite_its_size(group_id: str, label: str) -> None:
    assert text.group(group_id) == label


@pytest.mark.parametrize(
    ("long", "shortened"),
    [
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
        ("a `b` c", "a <code>b</code> c"),
        ("`<b>` & <i>", "<code>&lt;b&gt;</code> &amp; &lt;i&gt;"),
        ("see [the guide](docs/submit.md)", "see the guide"),
        ("[x](javascript:alert(1))", "x)"),
        ("one ` alone", "one ` alone"),
        ("level *re-evaluated*, 2 * 3 * 4", "level <em>re-evaluated</em>, 2 * 3 * 4"),
        ("`a*b*c`", "<code>a*b*c</code>"),
    ],
)
def test_code_is_marked_and_everything_else_escaped(source: str, markup: str) -> None:
    assert text.inline(source) == markup
