"""What is asked of the loop, checked before anything is run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from gym_extensions.catalog.errors import BenchError, did_you_mean
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import CURVE_POINTS, FIRST_REFERENCE_RUN, PROTOCOLS, Budget
from gym_extensions.catalog.protocol import budget as budget_named


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


def _several(given: str | int | Iterable[str] | Iterable[int]) -> list[str | int]:
    return [given] if isinstance(given, str | int) else list(given)


def checked(
    groups: str | Iterable[str],
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    lanes: int | None,
) -> Request:
    """The request; raises ``BenchError`` for an unknown name, a run that is not allowed, too many lanes."""
    names = tuple(dict.fromkeys(group(str(name)).name for name in _several(groups)))
    kinds = tuple(dict.fromkeys(str(kind) for kind in _several(protocols)))
    numbers = tuple(sorted({int(run) for run in _several(runs)}))
    for kind in kinds:
        if kind not in PROTOCOLS:
            hint = did_you_mean(kind, PROTOCOLS)
            raise BenchError("unknown-protocol", f"There is no protocol {kind!r}.", hint=hint)
    chosen = budget_named(budget)
    for run in numbers:
        if not 0 <= run < FIRST_REFERENCE_RUN:
            hint = f"Give numbers from 0 to {FIRST_REFERENCE_RUN - 1}; those above are for references."
            raise BenchError("bad-run", f"{run} is no run of a submission.", "--runs", hint)
    if not (names and kinds and numbers):
        raise BenchError("nothing-to-do", "No group, no protocol or no run is named.")
    if lanes is not None:
        _check_lanes(lanes, chosen, names)
    return Request(names, kinds, chosen, numbers)


def _check_lanes(lanes: int, chosen: Budget, names: Iterable[str]) -> None:
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
