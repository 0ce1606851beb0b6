"""The page of metrics has every formula."""

import re

from gym_extensions.metrics.formulas import METRICS
from gym_extensions.site.text import column

from ..browser import read


def test_the_metrics_page_has_every_formula_of_the_scorer() -> None:
    page = read({"format": 1, "references": {"version": "x", "sha256": ""}, "submissions": []})
    text = page["metrics.html"].text
    for metric in (metric for protocol in METRICS.values() for metric in protocol):
        assert re.sub(r"\s+", " ", metric.formula) in text
        assert metric.name in page["metrics.html"].ids
        name = column(metric.name)
        assert name == metric.title or f"{metric.title} in tables “{name}”" in text
