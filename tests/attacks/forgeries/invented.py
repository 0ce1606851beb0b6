"""Makes the attacks of the table of the same name in `families`."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.layout import MANIFEST

from ..forger import Forger, Row, cells, largest
from ..judge import Make
from ..workshop import Workshop

EditCell = Callable[[Forger, list[Row]], object]


def in_cells(edit: EditCell, base: str = "random") -> Make:
    """Changes every cell of single.csv, and commits to the result."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy(base))
        rows = forger.rows()
        for cell in cells(rows):
            edit(forger, cell)
        forger.write(rows)
        return forger.commit()

    return make


def in_rows(edit: Callable[[Forger, Row], object], base: str = "random") -> Make:
    """Changes every row of single.csv, and commits to the result."""
    return in_cells(lambda forger, cell: [edit(forger, row) for row in cell], base)


def add(forger: Forger, row: Row, gain: float) -> None:
    """Adds to the return and to the first segment of the trace."""
    arrays = forger.arrays(row)
    arrays["segment_returns"][0] += gain
    row["return"] = repr(float(row["return"]) + gain)
    forger.bind(row, arrays)


def scale(forger: Forger, row: Row, factor: float) -> None:
    """Scales the return and the segments of the trace."""
    arrays = forger.arrays(row)
    arrays["segment_returns"] *= factor
    row["return"] = repr(float(row["return"]) * factor)
    forger.bind(row, arrays)


def scale_log(forger: Forger, row: Row, factor: float) -> None:
    """Scales the return alone, and commits to the honest trace."""
    row["return"] = repr(float(row["return"]) * factor)
    forger.bind(row)


def two_largest(forger: Forger, cell: list[Row]) -> None:
    top = largest(cell)
    for row in cell[-2:]:
        forger.lose(row, top + 5.0)


def ten_below(forger: Forger, cell: list[Row]) -> None:
    """Invents the ten lowest returns just below the largest."""
    top = largest(cell)
    for row in sorted(cell, key=lambda row: float(row["return"]))[:10]:
        forger.lose(row, top * (1 - 1e-3))


def ground(workshop: Workshop) -> Path:
    """Invents ten of 20, and changes a digit per run until the sample without a salt misses all of them."""
    forger = Forger(workshop.copy("random"))
    rows = forger.rows()
    for cell in cells(rows):
        ten_below(forger, cell)
    for run in sorted({int(row["run"]) for row in rows}):
        mine = [row for row in rows if int(row["run"]) == run]
        invented = next(row for row in mine if not forger.stored(row).exists())
        start = float(invented["return"])
        for attempt in range(1000):
            invented["return"] = repr(start - attempt * 1e-9)
            forger.write(rows)
            sample = audit_sample("single", forger.log("single").read_bytes(), [run], forger.group.tasks)
            keys = {(item.task, item.episode) for item in sample}
            chosen = (row for row in mine if (row["task"], int(row["episode"])) in keys)
            if all(forger.stored(row).exists() for row in chosen):
                break
    return forger.commit()


def without_traces(forger: Forger) -> None:
    shutil.rmtree(forger.folder / forger.group.name / "traces")
    shutil.rmtree(forger.folder / ".progress")


def invented_without_traces(workshop: Workshop) -> Path:
    forger = Forger(workshop.copy("random"))
    forger.change(lambda row: row.update({"return": repr(float(row["return"]) + 100)}))
    without_traces(forger)
    return forger.folder


def later_runs_without_traces(workshop: Workshop) -> Path:
    """Honest runs 0 and 1 with their traces, and invented runs without."""
    forger = Forger(workshop.copy("random"))
    rows = forger.rows()
    for row in rows:
        if int(row["run"]) > 1:
            row["return"] = repr(float(row["return"]) + 100)
            forger.stored(row).unlink()
    forger.write(rows)
    return forger.commit()


def without_commitment(workshop: Workshop) -> Path:
    """A log in the form of old versions, without the column ``trace``."""
    forger = Forger(workshop.copy("random"))
    forger.change(lambda row: (row.pop("trace"), row.update({"return": repr(float(row["return"]) + 100)})))
    manifest = forger.folder / MANIFEST
    manifest.write_text(re.sub(r"(?s)\n\[traces\].*", "", manifest.read_text()), newline="\n")
    without_traces(forger)
    return forger.folder


def best_trace_everywhere(forger: Forger, cell: list[Row]) -> None:
    """Presents the best episode of a cell as all of its episodes."""
    best = max(cell, key=lambda row: float(row["return"]))
    arrays = forger.arrays(best)
    for row in cell:
        row |= {name: best[name] for name in ("length", "return", "terminated")}
        forger.bind(row, arrays)


def episodes_of_the_other_task(workshop: Workshop) -> Path:
    """Presents the episodes of each task as those of the other."""
    forger = Forger(workshop.copy("random"))
    rows = forger.rows()
    for run in range(0, len(rows), 40):
        first, second = rows[run : run + 20], rows[run + 20 : run + 40]
        for pair in zip(first, second, strict=True):
            results = [(forger.arrays(row), {name: row[name] for name in OUTCOME}) for row in pair]
            for target, (arrays, outcome) in zip(pair, reversed(results), strict=True):
                target.update(outcome)
                forger.bind(target, arrays)
    forger.write(rows)
    return forger.commit()


OUTCOME = ("length", "return", "terminated")


def one_episode(workshop: Workshop) -> Path:
    """Invents the lowest return of the log, below the largest of its cell."""
    forger = Forger(workshop.copy("random"))
    rows = forger.rows()
    cell = cells(rows)[0]
    lowest = min(cell, key=lambda row: float(row["return"]))
    forger.lose(lowest, largest(cell) * (1 - 1e-3))
    forger.write(rows)
    return forger.commit()
