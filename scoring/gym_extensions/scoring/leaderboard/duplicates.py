"""Entries that repeat another entry."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def repeats(found: Mapping[str, dict[str, Any]]) -> dict[str, str]:
    """Entries whose every metric is that of another in every run, by name, and the first such other."""
    alike: dict[tuple[tuple[float, ...], ...], list[str]] = {}
    for name, scored in sorted(found.items()):
        runs = tuple(tuple(metric["runs"]) for _, metric in sorted(scored["metrics"].items()))
        if any(runs):
            alike.setdefault(runs, []).append(name)
    return {
        name: names[1] if name == names[0] else names[0]
        for names in alike.values()
        for name in names
        if len(names) > 1
    }
