"""The colours of the style sheet have enough contrast in the light and the dark scheme."""

import re
from pathlib import Path

import pytest

import gym_extensions.site
from gym_extensions.site.charts.line_charts import LINE_STYLES

COLOURS, SHEET = (
    (Path(gym_extensions.site.__path__[0]) / "static" / name).read_text(encoding="utf-8")
    for name in ("masthead.css", "style.css")
)
LIGHT, DARK = (
    dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", block)) for block in COLOURS.split(":root {")[1:3]
)
HEAT_TINT, COLD_TINT = 0.61, 0.35
HATCHES = re.findall(r"--hatch: (#[0-9a-f]{6})([0-9a-f]{2});", COLOURS)


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb (WCAG 2.2)."""
    channels = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first: str, second: str) -> float:
    """Contrast ratio of two colours (WCAG 2.2)."""
    dark, light = sorted((luminance(first), luminance(second)))
    return (light + 0.05) / (dark + 0.05)


def mixed(colour: str, paper: str, share: float) -> str:
    """``color-mix(in srgb, colour share, paper)``."""
    pairs = [(int(colour[at : at + 2], 16), int(paper[at : at + 2], 16)) for at in (1, 3, 5)]
    return "#" + "".join(f"{round(a * share + b * (1 - share)):02x}" for a, b in pairs)


in_both_schemes = pytest.mark.parametrize("scheme", [LIGHT, DARK], ids=["light", "dark"])


@in_both_schemes
def test_numbers_are_readable_on_the_strongest_tint_and_marks_are_visible(scheme: dict[str, str]) -> None:
    for colour, share in (("heat", HEAT_TINT), ("cold", COLD_TINT)):
        assert contrast(scheme["ink"], mixed(scheme[colour], scheme["paper"], share)) >= 4.5, colour
    for mark in ("accent", "ring", "loss", "gain", "accent-bar", "ring-bar", "strong-rule", "cold"):
        for ground in ("paper", "raised"):
            assert contrast(scheme[mark], scheme[ground]) >= 3, f"{mark} on {ground}"
    assert f".h10 {{ --p: {HEAT_TINT:.0%} !important; }}" in SHEET
    assert f"var(--cold) {COLD_TINT:.0%}" in SHEET


@pytest.mark.parametrize(
    ("scheme", "hatch"), [(LIGHT, HATCHES[0]), (DARK, HATCHES[1])], ids=["light", "dark"]
)
def test_numbers_are_readable_on_hatching(scheme: dict[str, str], hatch: tuple[str, str]) -> None:
    tinted = mixed(scheme["heat"], scheme["paper"], HEAT_TINT)
    assert contrast(scheme["ink"], mixed(hatch[0], tinted, int(hatch[1], 16) / 255)) >= 4.5


@in_both_schemes
def test_lines_of_a_profile_differ_in_colour_and_in_dashes(scheme: dict[str, str]) -> None:
    rules = dict(re.findall(r"\.line\.p(\d) \{ (.*?) \}", SHEET))
    assert sorted(rules) == [str(kind) for kind in range(1, LINE_STYLES + 1)]
    colours = [re.findall(r"stroke: var\(--([\w-]+)\)", rule)[0] for rule in rules.values()]
    dashes = [re.findall(r"dasharray: ([\d. ]+)", rule) for rule in rules.values()]
    assert len(set(colours)) == len(set(map(tuple, dashes))) == LINE_STYLES
    assert min(contrast(scheme[colour], scheme["paper"]) for colour in colours) >= 3
