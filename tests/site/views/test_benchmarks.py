"""The page of speeds: each chapter in its own words, and no column without a name."""

from __future__ import annotations

import re
from typing import Any

import pytest

from gym_extensions.site.views.benchmarks import race
from gym_extensions.site.views.memory import footprint

from ..reading import Reader, files


def memory(ratio: float) -> dict[str, Any]:
    """A footprint as `make bench` writes it: limit / peak, so that above 1 is good."""
    return {
        "measure": "memory",
        "rounds": 1,
        "per_second": {"512 lanes": round(ratio, 1), "1.5 GB": 1.0},
        "ratios": {"1.5 GB": ratio},
        "bars": {"1.5 GB": 1.0},
    }


@pytest.mark.parametrize(("ratio", "peak", "kept"), [(1.25, 1.2, True), (1.0, 1.5, True), (0.75, 2.0, False)])
def test_a_footprint_is_a_peak_beside_its_limit(ratio: float, peak: float, kept: bool) -> None:
    found = footprint(memory(ratio))
    assert (found.name, found.limit) == ("512 lanes", 1.5)
    assert found.peak == pytest.approx(peak)
    assert found.kept is kept


def test_memory_is_told_in_gigabytes_and_never_as_a_speed(document: dict[str, Any]) -> None:
    text = dict(files(document))["speed.html"]
    (section,) = re.findall(r'<section aria-labelledby="memory">.*?</section>', text, re.DOTALL)
    said = Reader(section).said
    assert "Peak memory Limit Limit / peak" in said
    assert re.search(r"512 Humanoid lanes \d\.\d\d GB 1\.50 GB (kept|exceeded) \d\.\d\d", said)
    assert "er second" not in said
    assert "fast" not in said
    assert "1.5 GB" not in Reader(text.replace(section, "")).said


def test_no_page_has_a_column_without_a_name(document: dict[str, Any]) -> None:
    for path, text in files(document):
        assert not re.findall(r"<th[^>]*>\s*</th>", text), path


def test_the_first_of_a_race_is_ours_and_the_others_say_how_it_compares() -> None:
    row = {
        "measure": "stepping",
        "task": "Hopper",
        "lanes": 64,
        "per_second": {"ours": 200.0, "theirs": 50.0},
    }
    found = race(row | {"ratios": {"theirs": 4.0}, "bars": {"theirs": 5.0}})
    ours, theirs = found.contestants
    assert (ours.share, ours.ratio, ours.reached) == (1.0, None, None)
    assert (theirs.share, theirs.ratio, theirs.reached) == (0.25, 4.0, False)
    assert found.about == "64 lanes"
