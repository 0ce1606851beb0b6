"""The speed page: ratios, targets, peak memory."""

from __future__ import annotations

import re
from typing import Any

from gym_extensions.site.pages.speed import comparison, peak_memory

from ..browser import Reader, files


def test_peak_memory_is_compared_with_its_limit() -> None:
    row = {"per_second": {"512 environments": 1.2, "1.5 GB": 1.0}, "ratios": {"1.5 GB": 1.25}}
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
        "environments": 64,
        "threads": 1,
        "per_second": {"make_vec": 200.0, "Batch.step": 50.0},
        "ratios": {"Batch.step": 4.0},
        "bars": {"Batch.step": 5.0},
    }
    ours, theirs = comparison(row).variants
    assert (ours.name, ours.share, ours.ratio) == ("make_vec", 1.0, None)
    assert (theirs.name, theirs.share, theirs.ratio, theirs.target) == ("Batch.step", 0.25, 4.0, 5.0)
    assert comparison(row).settings == "64 environments, 1 thread"
