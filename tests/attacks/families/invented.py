"""Attacks with invented returns, and with digests and roots that hide them."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.layout import MANIFEST

from ..attack import REEVALUATED, REPRODUCED, Attack
from ..forger import Forger, Row, cells, largest
from ..judge import Make, submission
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
            for row, (arrays, outcome) in zip(pair, reversed(results), strict=True):
                row |= outcome
                forger.bind(row, arrays)
    forger.write(rows)
    return forger.commit()


OUTCOME = ("length", "return", "terminated")


def sequential(edit: Callable[[Forger, list[Row]], object]) -> Make:
    """Changes the cells R[s][j] with 0 < s < j, which no drawn episode covers."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("linear"))
        rows = forger.rows("sequential")
        for cell in cells(rows):
            index = forger.group.task_ids.index(cell[0]["task"]) + 1
            if 0 < int(cell[0]["stage"]) < index:
                edit(forger, cell)
        forger.write(rows, "sequential")
        return forger.commit()

    return make


def all_but_largest(forger: Forger, cell: list[Row]) -> None:
    top = largest(cell)
    for row in cell:
        if float(row["return"]) < top:
            forger.lose(row, top - 1e-3, "sequential")


def one_episode(workshop: Workshop) -> Path:
    """Invents the lowest return of the log, below the largest of its cell."""
    forger = Forger(workshop.copy("random"))
    rows = forger.rows()
    cell = cells(rows)[0]
    lowest = min(cell, key=lambda row: float(row["return"]))
    forger.lose(lowest, largest(cell) * (1 - 1e-3))
    forger.write(rows)
    return forger.commit()


def log_only(edit: Callable[[Row], object]) -> Make:
    """Changes rows, and leaves everything else."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        forger.change(edit)
        return forger.folder

    return make


def first_row(**values: str) -> Make:
    """Changes cells of the first row."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        rows = forger.rows()
        rows[0] |= values
        forger.write(rows)
        return forger.folder

    return make


def fewer(workshop: Workshop) -> Path:
    """Leaves the five worst episodes of every cell out."""
    forger = Forger(workshop.copy("random"))
    rows = []
    for cell in cells(forger.rows()):
        worst = sorted(cell, key=lambda row: float(row["return"]))[:5]
        rows += [row for row in cell if row not in worst]
    forger.write(rows)
    return forger.commit()


def other_root(workshop: Workshop) -> Path:
    forger = Forger(workshop.copy("random"))
    forger.declare("root", f'"{"5a" * 32}"')
    return forger.folder


ATTACKS = (
    Attack(
        "Two of 20 episodes of every cell are invented above all others.",
        submission(in_cells(two_largest)),
        "replay: trace-missing",
        quick=True,
    ),
    Attack(
        "Ten of 20 are invented below the largest; a digit is changed until the unsalted sample misses them.",
        submission(ground),
        "salted replay: trace-missing",
        quick=True,
    ),
    Attack(
        "All returns are invented, and there are no traces.",
        submission(invented_without_traces),
        "board: 20 of 20 traces of the audit sample are missing.",
        quick=True,
    ),
    Attack(
        "All returns are invented in a log of the old form, without digests of traces.",
        submission(without_commitment),
        "board: The log does not commit to traces.",
        quick=True,
    ),
    Attack(
        "All returns are halved in the log; the digests stay.",
        submission(log_only(lambda row: row.update({"return": repr(float(row["return"]) / 2)}))),
        "replay: trace-malformed, trace-missing",
    ),
    Attack(
        "All returns are scaled by 1.1 in the log, with digests to match.",
        submission(in_rows(lambda forger, row: scale_log(forger, row, 1.1))),
        "replay: trace-malformed",
    ),
    Attack(
        "All returns are scaled by 1.1 in the log and in the traces.",
        submission(in_rows(lambda forger, row: scale(forger, row, 1.1))),
        "replay: replay-differs",
        quick=True,
    ),
    Attack(
        "A bonus of 50 is added to the first segment of every trace.",
        submission(in_rows(lambda forger, row: add(forger, row, 50.0))),
        "replay: replay-differs",
    ),
    Attack(
        "A bonus of 0.001 is added to the first segment of every trace.",
        submission(in_rows(lambda forger, row: add(forger, row, 1e-3))),
        "replay: replay-differs",
    ),
    Attack(
        "All returns are raised by a ten-millionth, less than the tolerance of replay.",
        submission(in_rows(lambda forger, row: scale(forger, row, 1 + 1e-7))),
        "not detected",
        REPRODUCED,
        REPRODUCED,
        "Nothing: the gain is below any difference on a board.",
    ),
    Attack(
        "The trace of the best episode of a cell is used for all of its episodes.",
        submission(in_cells(best_trace_everywhere)),
        "replay: replay-differs",
    ),
    Attack(
        "The episodes of one task are presented as those of another.",
        submission(episodes_of_the_other_task),
        "replay: replay-differs",
    ),
    Attack(
        "All cells R[s][j] with 0 < s < j are invented.",
        submission(
            sequential(
                lambda forger, cell: [forger.lose(row, largest(cell) + 5.0, "sequential") for row in cell]
            )
        ),
        "replay: trace-missing",
    ),
    Attack(
        "All episodes of the cells R[s][j] with 0 < s < j but the largest are invented, just below it.",
        submission(sequential(all_but_largest)),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        "A drawn episode in these cells, or a replay of the archive of all traces. The metrics of transfer and "
        "of later forgetting use these cells; final performance does not.",
    ),
    Attack(
        "One episode of the log is invented, below the largest of its cell.",
        submission(one_episode),
        "not detected",
        REPRODUCED,
        REPRODUCED,
        "A replay of the archive of all traces. The level states how many of the episodes were replayed.",
    ),
    Attack(
        "A return is beyond what the task can give.",
        submission(first_row(**{"return": "1000000.0"})),
        "rules: impossible-return",
        quick=True,
    ),
    Attack(
        "A return is infinite.", submission(first_row(**{"return": "inf"})), "rules: not-finite", quick=True
    ),
    Attack(
        "An episode has more steps than the time limit.",
        submission(first_row(length="1001")),
        "rules: impossible-length",
        quick=True,
    ),
    Attack(
        "A fall is logged as the end of an episode that goes on.",
        submission(log_only(lambda row: row.update(terminated="false"))),
        "rules: unfinished-episode",
        quick=True,
    ),
    Attack(
        "The lengths of the log are one step longer.",
        submission(log_only(lambda row: row.update(length=str(int(row["length"]) + 1)))),
        "replay: trace-malformed, trace-missing",
    ),
    Attack(
        "The five worst episodes of every cell are left out.",
        submission(fewer),
        "rules: missing-cell",
        quick=True,
    ),
    Attack("The manifest states another root.", submission(other_root), "rules: different-root", quick=True),
    Attack(
        "A seed of the log is another one.",
        submission(first_row(seed="1")),
        "rules: wrong-seed",
        quick=True,
    ),
    Attack(
        "The fingerprint is that of another model.",
        submission(log_only(lambda row: row.update(fingerprint="0" * 16))),
        "rules: foreign-fingerprint",
        quick=True,
    ),
)
