"""The speed page: ratios, targets, peak memory, and public names of what was measured."""

from __future__ import annotations

import re
from typing import Any

import pytest

from gym_extensions.site.pages.speed import comparison, label, peak_memory

from ..browser import Reader, files


def test_peak_memory_is_compared_with_its_limit() -> None:
    row = {"per_second": {"512 lanes": 1.2, "1.5 GB": 1.0}, "ratios": {"1.5 GB": 1.25}}
    name, peak, limit = peak_memory(row)
    assert (name, round(peak, 6), limit) == ("512 environments", 1.2, 1.5)


def test_memory_is_shown_in_gigabytes_and_not_as_a_speed(document: dict[str, Any]) -> None:
    page = dict(files(document))["speed.html"]
    (section,) = re.findall(r'<section aria-labelledby="memory">.*?</section>', page, re.DOTALL)
    text = Reader(section).text
    assert "Peak memory Limit Limit / peak" in text
    assert re.search(r"512 Humanoid environments \d\.\d\d GB 1\.50 GB (met|exceeded) \d\.\d\d", text)
    assert "er second" not in text
    assert "fast" not in text
    assert "1.5 GB" not in Reader(page.replace(section, "")).text


def test_the_first_variant_is_compared_with_the_others() -> None:
    row = {
        "task": "Hopper",
        "lanes": 64,
        "threads": 1,
        "per_second": {"make_batch": 200.0, "Batch.step": 50.0},
        "ratios": {"Batch.step": 4.0},
        "bars": {"Batch.step": 5.0},
    }
    ours, theirs = comparison(row).variants
    assert (ours.name, ours.share, ours.ratio) == ("make_vec", 1.0, None)
    assert (theirs.name, theirs.share, theirs.ratio, theirs.target) == ("Batch.step", 0.25, 4.0, 5.0)
    assert comparison(row).settings == "64 environments, 1 thread"


@pytest.mark.parametrize(
    ("name", "public"),
    [
        ("1 lanes", "1 environment"),
        ("512 lanes", "512 environments"),
        ("512 Humanoid lanes", "512 Humanoid environments"),
        ("make_batch", "make_vec"),
        ("EnvPool", "EnvPool"),
    ],
)
def test_a_measured_variant_has_its_public_name(name: str, public: str) -> None:
    assert label(name) == public
