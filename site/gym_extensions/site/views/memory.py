"""One measured footprint as the page shows it: the peak, the limit that was set, how the two compare."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

MEASURE = "memory"
"""The rows of the ratios' file that are footprints: limit / peak stands there in place of speeds."""


@dataclass(frozen=True)
class Footprint:
    """The most memory that a whole process takes at once, and its limit, in GB."""

    name: str
    limit: float
    ratio: float

    @property
    def peak(self) -> float:
        """Peak memory in GB."""
        return self.limit / self.ratio

    @property
    def kept(self) -> bool:
        """Whether it stays within its limit."""
        return self.ratio >= 1


def footprint(row: Mapping[str, Any]) -> Footprint:
    """A row of the ratios' file: what was measured, and a limit by the name of its size, as ``1.5 GB``."""
    name, *_ = row["per_second"]
    ((limit, ratio),) = row["ratios"].items()
    return Footprint(name, float(limit.removesuffix(" GB")), ratio)
