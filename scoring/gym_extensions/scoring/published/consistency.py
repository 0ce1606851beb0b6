"""What in a published table contradicts itself: found by checks of the printed numbers, not typed in."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from gym_extensions.scoring.metrics.paper_table import COLUMNS
from gym_extensions.scoring.published.tables import Printed, PrintedGroup

ROUNDED = 0.0115
"""How far a printed mean may be from the recomputed one: rows and totals are rounded or cut."""


def row_mean(cells: Sequence[Printed]) -> float:
    """The mean of the rows' means."""
    return math.fsum(cell.mean for cell in cells) / len(cells)


def averaged(cells: Sequence[Printed]) -> float:
    """The mean of the rows' standard deviations."""
    return math.fsum(cell.std for cell in cells) / len(cells)


def pooled(cells: Sequence[Printed]) -> float:
    """The standard deviation of all episodes together: √(mean(σ²) + population variance of the means)."""
    centre = row_mean(cells)
    return math.sqrt(math.fsum(_square(c, centre) for c in cells) / len(cells))


def _square(cell: Printed, centre: float) -> float:
    """The mean square of a row's episodes about that centre: σ² + (mean − centre)².

    By products: ``**`` is the C library's ``pow``, whose last bit differs from machine to machine.
    """
    gap = cell.mean - centre
    return cell.std * cell.std + gap * gap


def mean_agrees(group: PrintedGroup, column: str) -> bool:
    """Whether a printed total mean is the mean of the rows, as far as rounding allows."""
    return abs(group.total[column].mean - row_mean(group.column(column))) <= ROUNDED


def deviation_rule(group: PrintedGroup, column: str) -> str:
    """How a printed total deviation was made: ``pooled``, ``averaged``, or empty where it fits neither."""
    total, cells = group.total[column], group.column(column)
    slack = max(ROUNDED, total.unit)
    if abs(total.std - pooled(cells)) <= slack:
        return "pooled"
    return "averaged" if abs(total.std - averaged(cells)) <= slack else ""


def copies(groups: Mapping[str, PrintedGroup]) -> Iterator[tuple[tuple[str, str], tuple[str, str]]]:
    """Pairs of (group id, environment) whose Fully Trained cells are the same digit for digit."""
    cells = [
        ((group.id, name), row["fully_trained"])
        for group in groups.values()
        for name, row in group.rows.items()
    ]
    for index, (first, cell) in enumerate(cells):
        yield from ((first, second) for second, other in cells[index + 1 :] if cell == other)


def repair(group: PrintedGroup, column: str, name: str) -> Printed:
    """The cell that, in the named row's place, would give the printed total (pooled deviation)."""
    others = [cells[column] for row, cells in group.rows.items() if row != name]
    count, total = len(others) + 1, group.total[column]
    mean = count * total.mean - math.fsum(cell.mean for cell in others)
    square = count * total.std * total.std - math.fsum(_square(c, total.mean) for c in others)
    gap = mean - total.mean
    return Printed(mean, math.sqrt(max(0.0, square - gap * gap)))


def _wrong_means(group: PrintedGroup, groups: Mapping[str, PrintedGroup]) -> Iterator[str]:
    for column, printed in group.total.items():
        if mean_agrees(group, column):
            continue
        found = row_mean(group.column(column))
        told = f"The printed total mean of {COLUMNS[column]}, {printed.mean:.2f},"
        yield f"{told} is not the mean of its rows, {found:.2f}."
        for pair in copies(groups):
            for (here, name), (there, other) in (pair, pair[::-1]):
                if here == group.id:
                    yield _copy(group, column, name, f"{other} of {there}")


def _copy(group: PrintedGroup, column: str, name: str, other: str) -> str:
    cell, right = group.rows[name][column], repair(group, column, name)
    return (
        f"The row {name}, {cell.mean:.2f} ± {cell.std:.2f}, repeats {other} digit for digit; "
        f"{right.mean:.2f} ± {right.std:.1f} in its place would give the printed total. "
        "Nothing here is computed from that value."
    )


def _wrong_deviations(group: PrintedGroup) -> Iterator[str]:
    for column, printed in group.total.items():
        if not deviation_rule(group, column):
            cells = group.column(column)
            yield (
                f"The printed total deviation of {COLUMNS[column]}, {printed.std:.2f}, is neither that of "
                f"all episodes pooled, {pooled(cells):.2f}, nor the rows' averaged, {averaged(cells):.2f}."
            )
    rules = {rule: [COLUMNS[c] for c in group.total if deviation_rule(group, c) == rule] for rule in RULES}
    if all(rules.values()):
        told = "; ".join(f"{RULES[rule]} in {', '.join(columns)}" for rule, columns in rules.items())
        yield f"Total deviations cannot be compared between columns: {told}."


RULES = {"pooled": "all episodes pooled", "averaged": "the rows' deviations averaged"}


def _scratch(group: PrintedGroup) -> list[tuple[str, str, Printed]]:
    """Cells of a policy trained from scratch: After Env Training of the first row, and Single Env."""
    first = next(iter(group.rows))
    found = [(first, "after_env_training", group.rows[first]["after_env_training"])]
    return found + [
        (n, "single_env", row["single_env"]) for n, row in group.rows.items() if "single_env" in row
    ]


def _twice(group: PrintedGroup, groups: Mapping[str, PrintedGroup]) -> Iterator[str]:
    every = [(other.id, *cell) for other in groups.values() for cell in _scratch(other)]
    first = next(iter(group.rows))
    same = [cell for cell in every if cell[1] == first]
    if len(same) > 1:
        told = "; ".join(f"{c.mean:.2f} ± {c.std:.2f} ({COLUMNS[col]}, {where})" for where, _, col, c in same)
        yield f"{first} is trained from scratch {len(same)} times, with different results: {told}."


def contradictions(group: PrintedGroup, groups: Mapping[str, PrintedGroup]) -> list[str]:
    """Everything in a group's printed numbers that does not fit together, in sentences."""
    return [*_wrong_means(group, groups), *_wrong_deviations(group), *_twice(group, groups)]
