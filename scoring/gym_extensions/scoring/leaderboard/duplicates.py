"""Entries whose results equal those of another entry."""

from __future__ import annotations

from collections.abc import Mapping

from gym_extensions.scoring.metrics.value import MetricValue


def duplicate_entries(entries: Mapping[str, Mapping[str, MetricValue]]) -> dict[str, str]:
    """The first other entry that an entry equals in every metric and run, by name of the entry.

    Args:
        entries: metrics by the entry's name. Entries without a value per run equal no other entry.
    """
    names_by_runs: dict[tuple[tuple[str, tuple[float, ...]], ...], list[str]] = {}
    for name, metrics in sorted(entries.items()):
        runs = tuple((metric, metrics[metric].runs) for metric in sorted(metrics))
        if any(values for _, values in runs):
            names_by_runs.setdefault(runs, []).append(name)
    return {
        name: names[1] if name == names[0] else names[0]
        for names in names_by_runs.values()
        for name in names
        if len(names) > 1
    }
