"""The page of the core: what each method takes and lacks, and a figure of them."""

from collections.abc import Sequence
from itertools import product

from markupsafe import Markup, escape

from gym_extensions.metrics import formulas
from gym_extensions.scoring.ranking.boards import CoreReference, CoreRow
from gym_extensions.scoring.scorecard import CoreScore, RunCost, Scorecard
from gym_extensions.site.charts.svg import Scale, picture, px, scale_around, stroke, text, tick_label
from gym_extensions.site.text import count, fixed, grouped, mean, short, split_version

FINAL, LEARNING, FORGETTING = (each.name for each in (formulas.FINAL, formulas.LEARNING, formulas.FORGETTING))
"""The names of the metrics of the core."""
EDITIONS = {
    1: "First edition: verified runs are ranked. Once the project has trained its reference agent itself, "
    "only runs trained by the project will be ranked.",
    2: "Second edition: the project trained every run that is ranked, from the author’s code, on seeds that "
    "nobody knew before.",
}
"""What the core ranks, by edition."""
EXPLORATORY = {1: "preliminary", 2: "exploratory"}
"""What a significant difference is called that no plan named before its runs existed, by edition."""
FIRST = 20
"""Methods in a figure."""
MOST_ROWS = 200
"""Most methods on the page of the core."""


def state(row: CoreRow | CoreScore) -> str:
    """Why a method is not ranked, for example ``lacks walker2d-wall, hopper-body``; empty if it is."""
    if row.missing:
        return f"lacks {', '.join(split_version(group)[0] for group in row.missing)}"
    return row.why


def notes(row: CoreRow | CoreScore) -> str:
    """What of a method is not compared, in sentences, without their codes.

    That groups have different numbers of runs says nothing beside which runs are not compared.
    """
    said = {code: text for code, _, text in (note.partition(": ") for note in row.notes)}
    if "runs-beyond-the-look" in said:
        said.pop("different-numbers-of-runs", None)
    return " ".join(said.values())


def shared_notes(rows: Sequence[CoreRow]) -> dict[str, list[str]]:
    """The methods with a score by what of them is not compared: each sentence once."""
    found: dict[str, list[str]] = {}
    for row in rows:
        if row.notes and row.metrics[FINAL].mean is not None:
            found.setdefault(notes(row), []).append(row.name)
    return found


def cost(card: Scorecard) -> tuple[str, str]:
    """Training steps and processor time of a run, for example ``8.7M steps``, ``21 min in 6 of 7 groups``.

    The time has the number of its runs. Fewer than 100,000 steps and less than a minute are whole numbers. No
    time, and a dash, where no run states it.
    """
    if (found := card.cost) is None:
        return "–", ""
    scope = f" in {count(found.groups, 'group')}" if card.core is None or card.core.missing else ""
    minutes, timed = found.cpu_seconds / 60, found.timed_groups
    partly = f" in {timed} of {found.groups} groups" if timed < found.groups else ""
    spent = f"{fixed(minutes, int(minutes < 10))} min" if minutes >= 1 else f"{fixed(found.cpu_seconds, 0)} s"
    return (
        f"{short_count(found.steps)} steps{scope}",
        f"{spent}{partly}, {timed_runs(found)}" if timed else "",
    )


def timed_runs(found: RunCost) -> str:
    """Over how many runs a processor time is the mean: of each group those that state it."""
    fewest, most = found.timed_runs
    return f"mean of {'' if fewest == most else f'{fewest} to '}{count(most, 'run')} per group"


def short_count(steps: float) -> str:
    """A number of steps: in millions from 100,000."""
    return f"{fixed(steps / 1e6, 1)}M" if steps >= 1e5 else grouped(round(steps))


SIDE, LEFT, TOP, BOTTOM = 400.0, 46.0, 16.0, 44.0
"""Side of the square of the figure, and the space around it for labels."""
CHARACTER = 6.4
"""About the width of a label's character."""
LABEL = "*"
"""Follows the name of a method that is given the task label."""
MAX_LABEL = 22
"""Most characters of a label."""
BESIDE = (-8, 17, 4)
LINES = (*BESIDE, -21, 30, -34, 43)
"""Where a label may stand below its point. Beside the point, it needs no line that leads there."""
Box = tuple[float, float, float, float]
"""Left, top, right and bottom."""


def figure(rows: Sequence[CoreRow], references: Sequence[CoreReference] = ()) -> Markup:
    """Learned (x) against kept at the end (y): a point per method with both intervals.

    On the diagonal nothing is lost; the best corner is at the top right. Empty without a ranked method.
    Submissions are best first; those without a score are left out. References are drawn as levels.
    """
    shown = [row for row in rows if row.metrics[FINAL].mean is not None]
    if not shown:
        return Markup("")
    reach = [*ends_of(shown), *(each.value.mean or 0.0 for each in references)]
    x = scale_around(reach, LEFT, LEFT + SIDE, always=())
    y = scale_around(reach, TOP + SIDE, TOP, always=())
    # The line where nothing is lost, and the corner where everybody wants to be.
    corner = f"M{px(x.end - 74)} {px(y.end)}H{px(x.end)}V{px(y.end + 74)}Z"
    at = (x.start + 0.14 * (x.end - x.start), y.start - 0.14 * (y.start - y.end) - 6)
    below = [
        f'<path class="corner" d="{corner}"/>',
        stroke(x.start, y.start, x.end, y.end, "diagonal"),
        f'<text class="axis" transform="translate({px(at[0])} {px(at[1])}) rotate(-45)">nothing lost</text>',
        text("axis best", x.end - 8, y.end + 18, "best"),
    ]
    for each in references:
        level = y.at(each.value.mean or 0.0)
        below.append(stroke(x.start, level, x.end, level, "way"))
        below.append(text("label way", x.start + 6, level - 5, str(escape(each.title))))
    parts = "".join([*_axes(x, y), *below, *_points(shown, x, y)])
    label = "Learned against kept, a point per method"
    return picture("plane", LEFT + SIDE + 8, TOP + SIDE + BOTTOM, label, parts)


def _points(rows: Sequence[CoreRow], x: Scale, y: Scale) -> list[str]:
    """The methods with their intervals and names."""
    places = [(x.at(row.metrics[LEARNING].mean or 0), y.at(row.metrics[FINAL].mean or 0)) for row in rows]
    parts, bars = [], []
    for number, (row, (left, up)) in reversed(list(enumerate(zip(rows, places, strict=True)))):
        learned, kept = row.metrics[LEARNING], row.metrics[FINAL]
        kind = "unranked" if not row.ranked else "other" if number else "first"
        ways = [(x.at(learned.ends[0]), up, x.at(learned.ends[1]), up)] if learned.ends else []
        ways += [(left, y.at(kept.ends[1]), left, y.at(kept.ends[0]))] if kept.ends else []
        if ways:
            drawn = "".join(f"M{px(x0)} {px(y0)}L{px(x1)} {px(y1)}" for x0, y0, x1, y1 in ways)
            parts.append(f'<path class="whisker {kind}" d="{drawn}"/>')
        bars += ways
        title = f"{short(row.name, MAX_LABEL)}: learned {mean(learned)}, kept {mean(kept)}"
        parts.append(
            f'<circle class="method {kind}" cx="{px(left)}" cy="{px(up)}">'
            f"<title>{escape(title)}</title></circle>"
        )
    names = [short(row.name, MAX_LABEL) + LABEL * row.task_conditioned for row in rows]
    return parts + _labels(names, places, bars)


def ends_of(rows: Sequence[CoreRow]) -> list[float]:
    """The ends of the intervals of what was learned and kept."""
    values = [row.metrics[metric] for row in rows for metric in (FINAL, LEARNING)]
    return [end for each in values if each.mean is not None for end in each.ends or (each.mean,)]


def _axes(x: Scale, y: Scale) -> list[str]:
    parts = []
    for mark in x.ticks(5):
        parts.append(stroke(x.at(mark), y.start, x.at(mark), y.end, "level"))
        parts.append(text("tick", x.at(mark), y.start + 16, tick_label(mark)))
    for mark in y.ticks(5):
        parts.append(stroke(x.start, y.at(mark), x.end, y.at(mark), "level"))
        parts.append(text("tick side", x.start - 7, y.at(mark) + 3.5, tick_label(mark)))
    parts.append(text("axis", (x.start + x.end) / 2, y.start + 36, "learned: score right after the training"))
    turn = f"translate(12 {px((y.start + y.end) / 2)}) rotate(-90)"
    return [*parts, f'<text class="axis" transform="{turn}">kept: score at the end</text>']


def _labels(names: Sequence[str], places: Sequence[tuple[float, float]], bars: Sequence[Box]) -> list[str]:
    """The names where they cover no point and no other name, beside their points or with a line to them."""
    taken: list[Box] = [(across - 7, up - 7, across + 7, up + 7) for across, up in places]
    parts = []
    for name, (across, up) in zip(names, places, strict=True):
        width, best = CHARACTER * len(name), None
        for line, start in product(LINES, (9, -9 - width, -width / 2)):
            left, right = across + start, across + start + width
            top, bottom = up + line - 10, up + line + 3
            box = (left, top, right, bottom)
            is_inside = left > LEFT and right < LEFT + SIDE and top > TOP and bottom < TOP + SIDE
            if not is_inside or _overlaps(box, taken):
                continue
            if line in BESIDE:
                around, leader = (left - 8, top - 8, right + 8, bottom + 8), ""
            else:
                end = min(max(across, left), right), bottom if line < 0 else top
                around = (min(end[0], across), min(end[1], up), max(end[0], across), max(end[1], up))
                leader = stroke(across, up, *end, "leader")
            crowded = 3 * _overlaps(around, taken) + _overlaps(box, bars) + bool(leader)
            if best is None or crowded < best[0]:
                best = crowded, leader, box
        if best:
            _, leader, box = best
            taken.append(box)
            parts += [leader, text("label", box[0], box[3] - 3, str(escape(name)))]
    return parts


def _overlaps(box: Box, others: Sequence[Box]) -> int:
    """How many of the other boxes it overlaps."""
    return sum(
        box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
        for other in others
    )
