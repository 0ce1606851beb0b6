"""Scorecards for people: one screen per submission, or two submissions side by side.

Texts are printed literally, in color on a terminal, and 80 columns wide elsewhere.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, TypeVar

from rich.console import Console
from rich.table import Table
from rich.text import Text

from gym_extensions.catalog.groups import SUITES
from gym_extensions.errors import working
from gym_extensions.metrics.formulas import BY_NAME, METRICS
from gym_extensions.metrics.values import Estimate
from gym_extensions.scoring import scorecard
from gym_extensions.scoring.group_score import PAPER_COLUMNS, GroupScore, PaperCell, SuiteScore
from gym_extensions.scoring.submission.stages import task_name
from gym_extensions.submissions.problem import count
from gym_extensions.submissions.review import TRAINED_HERE

if TYPE_CHECKING:
    from gym_extensions.scoring.ranking.boards import Comparison

MAX_ROWS, MAX_NOTES = 16, 3
"""Most suites and groups, and most notes or passed verifications, on the screen of a submission."""
Item = TypeVar("Item")
THOUSANDS = 100_000
"""From this return on, the paper's table is printed in thousands."""


def console() -> Console:
    """Standard output. NO_COLOR is honored.

    Titles and file names come from strangers, so markup is off and they are printed literally.
    """
    return Console(highlight=False, markup=False, emoji=False)


def awaited(items: Iterator[Item], texts: Iterable[str]) -> Iterator[Item]:
    """The items; while one is waited for, a terminal shows its text."""
    for text in texts:
        with working(text):
            item = next(items)
        yield item


def number(value: float | None, digits: int = 3) -> str:
    """A number with a fixed count of digits, or a dash; -0.000 is 0.000."""
    return "–" if value is None else f"{value:z.{digits}f}"


def span(value: Estimate) -> str:
    """An interval, or a dash."""
    return "–" if value.low is None else f"{number(value.low)} to {number(value.high)}"


def plain_table(*columns: str) -> Table:
    """A table without lines, with the first column aligned left and the others right."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for index, column in enumerate(columns):
        table.add_column(column, justify="left" if index == 0 else "right", overflow="fold")
    return table


def show(out: Console, card: scorecard.Scorecard, chosen: bool = False) -> None:
    """One screen: level and review, the core score, then a line per suite and group, or groups in full.

    In full are the only group, and groups that the user has ``chosen``.
    """
    show_line(out, card)
    _verifications(out, card.verifications)
    for doubt in card.doubts:
        out.print(f"  {doubt}")
    reasons = (log.why_claimed for protocols in card.groups.values() for log in protocols.values())
    if why := next(filter(None, reasons), ""):
        out.print(f"  claimed: {why}")
    if card.level and not card.groups:
        out.print(f"  {scorecard.NO_RUNS}")
    if card.core and not (chosen and card.core.missing):
        _core(out, card.core)
    hint = ""
    if chosen or len(card.groups) == 1:
        for name, protocols in card.groups.items():
            for protocol, score in protocols.items():
                _group(out, name, protocol, score)
    else:
        _overview(out, card)
        hint = f"One group in full: --group {next(iter(card.groups), 'NAME')}. "
    if card.groups:
        out.print(f"{hint}All metrics: --json or --csv.", style="dim")
    out.print()


def show_line(out: Console, card: scorecard.Scorecard) -> None:
    """One line per submission, with all its problems and notes."""
    state = (str(card.level or "no runs of these groups"), "green")
    if card.problems:
        state = (count(len(card.problems), "problem"), "red")
    out.print(Text.assemble((card.name, "bold"), f"  {card.title}  (", state, ")"))
    for problem in card.problems:
        message = f"  {problem.where}: {problem.message}"
        out.print(Text.assemble("  ", (problem.rule, "red"), message))
        if problem.hint:
            out.print(f"    {problem.hint}")
    for note in card.notes[:MAX_NOTES]:
        out.print(f"  note: {note}")
    if len(card.notes) > MAX_NOTES:
        out.print(f"  … and {count(len(card.notes) - MAX_NOTES, 'note')} more: --json")


def _verifications(out: Console, parts: Sequence[scorecard.VerificationSummary]) -> None:
    """A line per verification. Of many, those that passed have one line, except the newest."""
    for part in parts:
        if len(parts) > MAX_NOTES and part.passed and part is not parts[-1]:
            continue
        agrees = "agrees" if part.passed else "does not agree"
        found = part.undecided or f"{agrees} on new seeds (p = {part.p_value:.3g})"
        if part.episodes:
            found += f", {part.repeated:,} of {part.episodes:,} episodes repeated"
        out.print(f"  verification of {part.date}: {count(part.runs, 'run')}, {found}")
    if len(parts) > 1:
        repeated = sum(part.repeated for part in parts)
        episodes = sum(part.episodes for part in parts)
        out.print(f"  all {len(parts)} verifications: {repeated:,} of {episodes:,} episodes repeated")


def _core(out: Console, core: scorecard.CoreScore) -> None:
    """The core score: means over the groups of the core, or why there are none."""
    runs = f", runs 0 to {core.look - 1} of every group" if core.look else ""
    runs += f", {TRAINED_HERE}" if core.trained_here else ""
    out.print()
    out.print(Text.assemble(("core", "bold"), runs))
    if core.look:
        table = plain_table("metric, mean over groups", "mean", "95 % interval")
        for name, value in core.metrics.items():
            table.add_row(BY_NAME[name].title, number(value.mean), span(value))
        out.print(table)
    if core.why:
        out.print(core.why)
    for note in core.notes:
        out.print(f"note: {note.partition(': ')[2]}")


def _group(out: Console, name: str, protocol: str, score: GroupScore) -> None:
    runs = f", {count(len(score.runs), 'run')}" if score.runs else ""
    custom = "" if score.published else ", custom group (not published)"
    facts = f", budget {score.budget}{runs}, {score.level}{custom}"
    out.print()
    out.print(Text.assemble((f"{name}, {protocol}", "bold"), facts))
    table = plain_table("metric", "mean", "95 % interval")
    reasons: dict[str, list[str]] = {}
    for metric in METRICS[protocol]:
        if "screen" not in metric.shown:  # --json and --csv have all
            continue
        value = score.metrics[metric.name]
        if value.mean is not None:
            table.add_row(metric.title, number(value.mean), span(value))
        else:
            reasons.setdefault(value.why, []).append(metric.title)
    if table.row_count:
        out.print(table)
    for why, titles in reasons.items():
        out.print(f"{', '.join(titles)}: none. {why}")
    if score.paper_table:
        table = plain_table(
            "task, mean ± deviation",
            *("\n".join(title.rsplit(" ", 1)) for title in PAPER_COLUMNS.values()),
        )
        rows = [(task_name(row.task), row.cells()) for row in score.paper_table]
        totals = (("total", score.paper_total), ("printed total", score.printed_total))
        for title, cells in (*rows, *((title, total.cells()) for title, total in totals if total)):
            table.add_row(title, *map(_returns, cells))
        out.print(table)
    for sentence in score.highlights:
        out.print(f"· {sentence}")
    for note in score.notes:
        out.print(f"! {note}")


def _returns(cell: PaperCell | None) -> str:
    """Mean and deviation of raw returns, in thousands where they would be too wide."""
    if cell is None:
        return "–"
    if max(abs(cell.mean), cell.std) >= THOUSANDS:
        return f"{cell.mean / 1000:.0f}k ± {cell.std / 1000:.0f}k"
    return f"{cell.mean:.0f} ± {cell.std:.0f}"


def _overview(out: Console, card: scorecard.Scorecard) -> None:
    recorded = {protocol for protocols in card.groups.values() for protocol in protocols}
    first = {protocol: metrics[0] for protocol, metrics in METRICS.items() if protocol in recorded}
    suites = {f"suite {name}": protocols for name, protocols in card.suites.items()}
    parts: list[tuple[str, Mapping[str, GroupScore | SuiteScore]]] = [
        *suites.items(),
        *card.groups.items(),
    ]
    rows = []
    for name, protocols in parts:
        cells = []
        for protocol, metric in first.items():
            value = protocols[protocol].metrics[metric.name] if protocol in protocols else Estimate()
            half = "" if value.high is None or value.mean is None else f"±{value.high - value.mean:.2f}"
            cells.append(f"{number(value.mean, 2)}{half}")
        if name in card.groups or any(cell != number(None) for cell in cells):
            rows.append((name, *cells))
    if not rows:
        return
    shown = rows if len(rows) <= MAX_ROWS else rows[: MAX_ROWS - 1]
    table = plain_table("", *first)
    table.columns[0].no_wrap = True
    for row in shown:
        table.add_row(*row)
    out.print()
    out.print("First metric of each protocol, ± half of its 95 % interval")
    out.print(table)
    if len(shown) < len(rows):
        out.print(f"… and {count(len(rows) - len(shown), 'group')} more")


def show_comparison(out: Console, first: str, second: str, comparisons: "Sequence[Comparison]") -> None:
    """Two submissions side by side, with the interval of their difference."""
    for each in comparisons:
        name = f"suite {each.name}" if each.name in SUITES else each.name
        runs = f", runs 0 to {each.look - 1} of every group" if each.look else ""
        out.print(Text.assemble((f"{name}, {each.protocol}", "bold"), f", budget {each.budget}{runs}"))
        table = plain_table("metric", first, second, "difference", "95 % interval")
        for metric in METRICS[each.protocol]:
            if metric.name in each.metrics:
                *means, difference = each.metrics[metric.name]
                table.add_row(metric.title, *map(number, (*means, difference.mean)), span(difference))
        out.print(table)
        if not table.row_count:
            hint = "see `score` on each. Custom groups need --references."
            out.print(f"They have no metric in common: {hint}")
    differences = [difference for each in comparisons for *_, difference in each.metrics.values()]
    if any(difference.ends for difference in differences):
        out.print("Intervals are for this pair alone (Welch); an interval without 0 separates the two.")
