"""The files that the page of an entry offers: metrics as CSV, a citation and a badge."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.addresses import entry_file
from gym_extensions.site.exports.badge import badge
from gym_extensions.site.exports.bibtex import bibtex
from gym_extensions.site.exports.metrics_csv import metrics_csv
from gym_extensions.site.page import File, Page, Render


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The files of one entry."""
    yield entry_file(entry.name, "badge.svg"), badge(entry)
    if not entry.problems:
        yield entry_file(entry.name, "metrics.csv"), metrics_csv(entry)
        yield entry_file(entry.name, "citation.bib"), bibtex(entry)


PAGE = Page(title="Exports", order=91, publish_entry=publish_entry)
