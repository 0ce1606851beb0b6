"""Checks of a published table: recomputed totals, and contradictions between printed numbers."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from gym_extensions.scoring.entry.published import PRINTED_COLUMNS, TOTAL, group_id, table_path
from gym_extensions.scoring.scorecard import PAPER_COLUMNS as COLUMNS

ROUNDING = 0.0115
"""Largest distance of a printed mean from the recomputed one: rows and totals are rounded or cut."""

RULES = {"pooled": "all episodes pooled", "averaged": "the rows' deviations averaged"}
"""How a total's deviation can be made."""


@dataclass(frozen=True)
class Printed:
    """A printed mean ± standard deviation; ``unit`` is that of the deviation's last digit."""

    mean: float
    std: float
    unit: float = 0.01


@dataclass
class PrintedGroup:
    """One group: cells by environment and column, and the printed totals by column."""

    id: str
    rows: dict[str, dict[str, Printed]] = field(default_factory=dict)
    total: dict[str, Printed] = field(default_factory=dict)

    def column(self, name: str) -> list[Printed]:
        """The cells of a column, in order; empty where the table does not have it."""
        return [cells[name] for cells in self.rows.values() if name in cells]


def printed_groups(name: str) -> dict[str, PrintedGroup]:
    """The groups of a published table by id, with the digits as printed."""
    groups: dict[str, PrintedGroup] = {}
    with table_path(name).open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            key = group_id(row["group"])
            group = groups.setdefault(key, PrintedGroup(key))
            cells = group.total if row["env"] == TOTAL else group.rows.setdefault(row["env"], {})
            unit = 10.0 ** -len(row["std"].partition(".")[2])
            cells[PRINTED_COLUMNS[row["column"]]] = Printed(float(row["mean"]), float(row["std"]), unit)
    return groups


def row_mean(cells: Sequence[Printed]) -> float:
    """The mean of the rows' means."""
    return math.fsum(cell.mean for cell in cells) / len(cells)


def averaged(cells: Sequence[Printed]) -> float:
    """The mean of the rows' standard deviations."""
    return math.fsum(cell.std for cell in cells) / len(cells)


def pooled(cells: Sequence[Printed]) -> float:
    """The standard deviation of all episodes together: √(mean(σ²) + population variance of the means)."""
    center = row_mean(cells)
    return math.sqrt(math.fsum(_square(cell, center) for cell in cells) / len(cells))


def _square(cell: Printed, center: float) -> float:
    """Mean square of a row's episodes about a center; the last bit of ``pow`` would depend on the machine."""
    gap = cell.mean - center
    return cell.std * cell.std + gap * gap


def mean_agrees(group: PrintedGroup, column: str) -> bool:
    """Whether a printed total mean is the mean of the rows, up to rounding."""
    return abs(group.total[column].mean - row_mean(group.column(column))) <= ROUNDING


def deviation_rule(group: PrintedGroup, column: str) -> str:
    """How a printed total deviation was made: ``pooled``, ``averaged``, or empty where neither fits."""
    total, cells = group.total[column], group.column(column)
    slack = max(ROUNDING, total.unit)
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
    """The cell that, in the named row, would give the printed total (pooled deviation)."""
    others = [cells[column] for row, cells in group.rows.items() if row != name]
    count, total = len(others) + 1, group.total[column]
    mean = count * total.mean - math.fsum(cell.mean for cell in others)
    square = count * total.std * total.std - math.fsum(_square(cell, total.mean) for cell in others)
    gap = mean - total.mean
    return Printed(mean, math.sqrt(max(0.0, square - gap * gap)))


def _wrong_means(group: PrintedGroup, groups: Mapping[str, PrintedGroup]) -> Iterator[str]:
    for column, printed in group.total.items():
        if mean_agrees(group, column):
            continue
        rows = row_mean(group.column(column))
        total = f"The printed total mean of {COLUMNS[column]}, {printed.mean:.2f},"
        yield f"{total} is not the mean of its rows, {rows:.2f}."
        for pair in copies(groups):
            for (group_of_copy, name), (group_of_other, other) in (pair, pair[::-1]):
                if group_of_copy == group.id:
                    yield _copy(group, column, name, f"{other} of {group_of_other}")


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
        sentence = "; ".join(f"{RULES[rule]} in {', '.join(columns)}" for rule, columns in rules.items())
        yield f"Total deviations cannot be compared between columns: {sentence}."


def _scratch(group: PrintedGroup) -> list[tuple[str, str, Printed]]:
    """Cells of a policy trained from scratch: After Env Training of the first row, and Single Env."""
    first = next(iter(group.rows))
    return [
        (first, "after_env_training", group.rows[first]["after_env_training"]),
        *((name, "single_env", row["single_env"]) for name, row in group.rows.items() if "single_env" in row),
    ]


def _trained_twice(group: PrintedGroup, groups: Mapping[str, PrintedGroup]) -> Iterator[str]:
    cells = [(other.id, *cell) for other in groups.values() for cell in _scratch(other)]
    first = next(iter(group.rows))
    same = [cell for cell in cells if cell[1] == first]
    if len(same) > 1:
        results = "; ".join(
            f"{cell.mean:.2f} ± {cell.std:.2f} ({COLUMNS[column]}, {where})"
            for where, _, column, cell in same
        )
        yield f"{first} is trained from scratch {len(same)} times, with different results: {results}."


def contradictions(group: PrintedGroup, groups: Mapping[str, PrintedGroup]) -> list[str]:
    """Every contradiction between a group's printed numbers, as sentences."""
    return [*_wrong_means(group, groups), *_wrong_deviations(group), *_trained_twice(group, groups)]
