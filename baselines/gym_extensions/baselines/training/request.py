"""What is asked of the loop, checked before anything is run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from operator import index
from typing import Any

from gym_extensions.catalog.budgets import Budget
from gym_extensions.catalog.budgets import budget as budget_named
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import CURVE_POINTS, FIRST_REFERENCE_RUN, PROTOCOLS
from gym_extensions.errors import BenchError, did_you_mean


@dataclass(frozen=True)
class Request:
    """Groups by their bare names, protocols, a budget and runs, each in order and once."""

    groups: tuple[str, ...]
    protocols: tuple[str, ...]
    budget: Budget
    runs: tuple[int, ...]

    def logs(self) -> list[tuple[str, str]]:
        """(group, protocol) of every log."""
        return [(name, protocol) for name in self.groups for protocol in self.protocols]


def _texts(given: object, what: str) -> list[str]:
    """The text alone, or several; raises ``BenchError`` for anything else, and for none."""
    found = [given] if isinstance(given, str) else list(given) if isinstance(given, Iterable) else []
    if not found or not all(isinstance(text, str) for text in found):
        hint = "Give a name, or a list of names."
        raise BenchError(f"bad-{what}", f"{given!r} names nothing.", what, hint)
    return found


def _numbers(given: Any) -> list[int]:
    """The number alone, or several; raises ``BenchError`` for anything else, and for none."""
    found = list(given) if isinstance(given, Iterable) and not isinstance(given, str | bytes) else [given]
    try:
        numbers = [index(number) for number in found]
    except TypeError:
        numbers = []
    if not numbers:
        hint = "Give a whole number or several, as in 0, [0, 1] or range(5)."
        raise BenchError("bad-runs", f"{given!r} is no list of runs.", "runs", hint)
    return numbers


def checked(
    groups: str | Iterable[str],
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    lanes: int | None,
) -> Request:
    """The request; raises ``BenchError`` for an unknown name, none, a run or lanes that are not allowed."""
    names = tuple(dict.fromkeys(group(name).name for name in _texts(groups, "groups")))
    kinds = tuple(dict.fromkeys(_texts(protocols, "protocols")))
    numbers = tuple(sorted(set(_numbers(runs))))
    for kind in kinds:
        if kind not in PROTOCOLS:
            hint = did_you_mean(kind, PROTOCOLS)
            raise BenchError("unknown-protocol", f"There is no protocol {kind!r}.", hint=hint)
    chosen = budget_named(str(budget))
    for run in numbers:
        if not 0 <= run < FIRST_REFERENCE_RUN:
            hint = f"Give numbers from 0 to {FIRST_REFERENCE_RUN - 1}; those above are for references."
            raise BenchError("bad-run", f"{run} is no run of a submission.", "--runs", hint)
    if lanes is not None:
        _check_lanes(lanes, chosen, names)
    return Request(names, kinds, chosen, numbers)


def _check_lanes(lanes: Any, chosen: Budget, names: Iterable[str]) -> None:
    if not isinstance(lanes, int):
        hint = "Give a whole number."
        raise BenchError("bad-lanes", f"{lanes!r} is no number of lanes.", "--lanes", hint)
    if lanes < 1:
        raise BenchError("bad-lanes", f"{lanes} training lanes are too few.", "--lanes", "Give at least 1.")
    if not chosen.on_boards:
        return
    for name in names:
        longest = max(task.max_steps for task in group(name).tasks)
        most = chosen.steps_for(name) // (longest * CURVE_POINTS)
        if lanes > most:
            message = (
                f"{lanes} lanes leave fewer than {CURVE_POINTS} episodes a lane in budget {chosen.name!r}."
            )
            raise BenchError("bad-lanes", message, "--lanes", f"Give at most {most} for {name}.")
