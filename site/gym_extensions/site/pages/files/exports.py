"""The files that the page of an entry offers: metrics as CSV, a citation and a badge."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.addresses import entry_file
from gym_extensions.site.exports.badge import badge
from gym_extensions.site.exports.bibtex import bibtex
from gym_extensions.site.exports.metrics_csv import metrics_csv
from gym_extensions.site.page import Draft, File, Page, Render


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The files of one entry."""
    texts = {"badge.svg": badge}
    if not entry.problems:
        texts |= {"metrics.csv": metrics_csv, "citation.bib": bibtex}
    for name, text in texts.items():
        yield entry_file(entry.name, name), Draft(render.inputs, partial(text, entry))


PAGE = Page(title="Exports", order=91, publish_entry=publish_entry)
