"""Entries whose results equal those of another entry."""

from __future__ import annotations

from collections.abc import Mapping

from gym_extensions.scoring.metrics.value import MetricValue


def duplicate_entries(entries: Mapping[str, Mapping[str, MetricValue]]) -> dict[str, str]:
    """The entry that an entry equals in every metric and run, by the name of the later one.

    Args:
        entries: metrics by the entry's name. Of equal entries, the first of the mapping is not a duplicate.
            Entries without a value per run equal no other entry.
    """
    originals: dict[tuple[tuple[str, tuple[float, ...]], ...], str] = {}
    duplicates = {}
    for name, metrics in entries.items():
        runs = tuple((metric, metrics[metric].runs) for metric in sorted(metrics))
        if any(values for _, values in runs) and originals.setdefault(runs, name) != name:
            duplicates[name] = originals[runs]
    return duplicates
