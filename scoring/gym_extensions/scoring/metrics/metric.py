"""The type of a row of the metrics' table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.statistics.descriptive import Number


@dataclass(frozen=True)
class Metric:
    """One metric.

    Attributes:
        name: its key in scorecards.
        title: its name on pages.
        formula: its definition as text.
        function: the same for one run; None where the value is not a function of one run (joint gap).
        better: ``higher``, ``lower`` or empty (not ranked).
        protocols: the protocols that it is a metric of.
        needs: files without ``.csv`` that it needs besides the protocol's own log.
        known_as: other names of the same formula.
        limits: what its value does not say.
    """

    name: str
    title: str
    formula: str
    function: Callable[[Run], Number] | None
    better: str
    protocols: tuple[str, ...] = ("sequential",)
    needs: tuple[str, ...] = ()
    known_as: str = ""
    limits: str = ""
