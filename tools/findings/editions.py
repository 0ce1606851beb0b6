"""The two editions of the core: what each has stated for good, and whose runs the page reads.

Of the first edition these are its statements and a page, so that its runs may leave the tree: they are
written with the page until a run of the core was trained here. Of the second one, the verdicts on its
hypotheses, which are written once.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import msgspec

from gym_extensions import references
from gym_extensions.files import write_text
from gym_extensions.scoring.ranking.boards import CoreBoard
from tools.findings.claims import Gain
from tools.findings.tables import (
    CORE,
    FINAL,
    FINE_TUNING,
    LEARNED,
    LOST,
    VERDICTS,
    WORDS,
    Forgetting,
    Value,
    of_edition,
)

Row = TypeVar("Row", bound=msgspec.Struct)
OPEN, SEPARATED = "open", "separated"
ALONE = "each task alone"


def stored(path: Path, kind: type[Row], state: Callable[[], Sequence[Row]], *, is_open: bool) -> list[Row]:
    """What a file states for good, a row per line of JSON; nothing without it. While open, it is written."""
    if is_open:
        lines = (msgspec.json.encode(each).decode() for each in state())
        write_text(path, "[\n" + ",\n".join(lines) + "\n]\n")
    return msgspec.json.decode(path.read_bytes(), type=list[kind]) if path.exists() else []  # type: ignore[valid-type]


class Statement(msgspec.Struct, frozen=True):
    """A value with its interval and verdict.

    Attributes:
        of: two names, whose difference it is, or one.
        metric: name of the metric.
        group: name of the group; empty for the mean over the core.
        value: with six decimals.
        verdict: ``separated`` (from 0), ``equivalent`` or ``open``.
        runs: how many it is over, of each name.
    """

    of: tuple[str, ...]
    metric: str
    group: str
    value: Value
    verdict: str
    runs: tuple[int, ...] = ()

    @property
    def subject(self) -> str:
        """What it is about, in words."""
        names = " − ".join(name if name == ALONE else f"`{name}`" for name in self.of)
        return f"{names}, {WORDS[self.metric]}{f' on {self.group}' if self.group else ''}"

    @property
    def direction(self) -> tuple[str, bool]:
        """The verdict, and whether a separated value is above 0."""
        return self.verdict, self.verdict == SEPARATED and self.value.mean > 0

    def turned(self) -> "Statement":
        """The same about the second name minus the first."""
        return msgspec.structs.replace(self, of=self.of[::-1], value=-self.value, runs=self.runs[::-1])

    def __str__(self) -> str:
        runs = " and ".join(map(str, dict.fromkeys(self.runs)))
        return f"{self.value}, {VERDICTS[self.verdict]}; {runs} runs"


def statements(
    board: CoreBoard, forgetting: Sequence[Forgetting], gains: Sequence[Gain], alone: Mapping[str, Value]
) -> list[Statement]:
    """What the page states of the core; nothing of values without runs.

    Args:
        board: its pairs.
        forgetting: what fine-tuning forgets by group, with the verdict of the page's table.
        gains: of cloning over fine-tuning by group.
        alone: by method, what it learned minus each task alone. Of these and of gains, those are separated
            whose interval does not contain 0.
    """
    looks = {row.name: row.look for row in board.rows}
    looks.update((ALONE, each.runs) for each in board.references if each.name == references.ALONE)
    found = []

    def state(of: tuple[str, ...], metric: str, group: str, value: Value, verdict: str) -> None:
        if value.is_known:
            runs = [looks.get(name, 0) for name in of]
            if not group and ALONE not in of:  # those of the last look of both
                runs = [min(runs)] * 2
            rounded = Value(*(round(end, 6) for end in value))
            found.append(Statement(of, metric, group, rounded, verdict, tuple(runs)))

    def by_interval(value: Value) -> str:
        return OPEN if value.low <= 0 <= value.high else SEPARATED

    for metric, pairs in board.pairs.items():
        for pair in pairs:
            value = Value(pair.mean, pair.low, pair.high)
            state((pair.first, pair.second), metric, "", value, pair.verdict)
    for row in forgetting:
        if row.group in CORE:
            verdict = SEPARATED if row.significant else OPEN
            state((FINE_TUNING,), LOST, row.group.name, row.metrics[LOST], verdict)
    for gain in gains:
        both = (of_edition("cloning", board.edition), FINE_TUNING)
        state(both, FINAL, gain.group, gain.gain, by_interval(gain.gain))
    for name, value in alone.items():
        state((name, ALONE), LEARNED, "", value, by_interval(value))
    return found


class Outcomes(NamedTuple):
    """The statements of the first edition, each with that of the second.

    Attributes:
        kept: with the same verdict, but those that are open in both.
        withdrawn: with another verdict, or another direction.
        untested: whose methods or runs are not compared in the second edition, but those that were open.
        open: the number of those that are open in both.
    """

    kept: list[tuple[Statement, Statement]]
    withdrawn: list[tuple[Statement, Statement]]
    untested: list[Statement]
    open: int


def outcomes(first: Sequence[Statement], second: Sequence[Statement]) -> Outcomes:
    """What became of the statements of the first edition."""
    # A statement about one name has one key, under which its own form comes last.
    known = {(form.of, form.metric, form.group): form for each in second for form in (each.turned(), each)}
    kept, withdrawn, untested, num_open = [], [], [], 0
    for before in first:
        names = tuple(of_edition(name, 2) for name in before.of)
        after = known.get((names, before.metric, before.group))
        if after and after.direction != before.direction:
            withdrawn.append((before, after))
        elif after and before.verdict == OPEN:
            num_open += 1
        elif after:
            kept.append((before, after))
        elif before.verdict != OPEN:
            untested.append(before)
    return Outcomes(kept, withdrawn, untested, num_open)
