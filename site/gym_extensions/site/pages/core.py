"""The answer of the overview: one row per method on the core suite, in sentences and as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

from markupsafe import Markup, escape

from gym_extensions.scoring.formulas import MetricValue
from gym_extensions.scoring.ranking.boards import CoreBoard, CoreCost, CoreEntry, CoreReference
from gym_extensions.scoring.ranking.core_board import core_board
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.board_views import value_of
from gym_extensions.site.charts.strips import MARGIN, WIDTH
from gym_extensions.site.charts.svg import Scale, picture, px, scale_around, stroke, text, tick_label
from gym_extensions.site.text import count, ends, fixed, grouped, mean, short, split_version

FINAL, LEARNED, LOST = "final_performance", "learning_performance", "forgetting"
TRANSFER = "zero_shot_transfer"
FIRST = 20
"""Methods on the overview."""
MOST_ROWS, MOST_PAIRS = 200, 400
"""Most methods, and pairs per metric, on the page of the core."""
MOST_NAMED = 3
"""Up to this many methods are named in a sentence; more are counted."""


def value(entry: CoreEntry, metric: str) -> MetricValue:
    """A metric of a method: mean and interval over the core; without a mean where it lacks a group."""
    return value_of(entry.metrics[metric])


def own_row(card: Scorecard) -> CoreEntry | None:
    """The row of one entry, without its rank; None if it has no runs on the core."""
    board = core_board([card])
    return board.rows[0] if board else None


def state(entry: CoreEntry) -> str:
    """Why a method is not ranked, for example ``lacks walker2d-wall, hopper-body``; empty if it is."""
    if entry.missing:
        return f"lacks {', '.join(split_version(group)[0] for group in entry.missing)}"
    return entry.why


def scale(entries: Sequence[CoreEntry]) -> Scale:
    """The scale of the drawn column, with every interval and 0."""
    values = [value(entry, metric) for entry in entries for metric in (FINAL, LEARNED)]
    reach = [end for each in values if each.mean is not None for end in _reach(each)]
    return scale_around(reach, MARGIN, WIDTH - MARGIN, always=(0.0, 0.5))


def price(cost: CoreCost) -> str:
    """Processor time of a run, for example ``21 min``; where it is not stated the steps, or a dash."""
    if cost.cpu_seconds is not None:
        minutes = cost.cpu_seconds / 60
        return f"{fixed(minutes, 0)} min" if minutes < 100 else f"{fixed(minutes / 60, 1)} h"
    return "–" if cost.steps is None else f"{fixed(cost.steps / 1e6, 1)}M steps"


def size(cost: CoreCost) -> str:
    """Stored transitions and parameters of a run of the core; empty where they are not stated."""
    if cost.stored_steps is None or cost.parameters is None:
        return ""
    return f"{grouped(cost.stored_steps)} transitions stored, {grouped(cost.parameters)} parameters"


def answers(board: CoreBoard | None) -> list[Markup]:
    """Who leads, who forgets least, and how certain either is, in sentences."""
    ranked = [entry for entry in board.rows if entry.ranked] if board else []
    if board is None or not ranked:
        return [Markup("No method has all runs of the core suite yet. Each row says what is missing.")]
    first = ranked[0]
    kept = value(first, FINAL)
    if len(ranked) == 1:
        return [
            Markup(
                "{} is the only method with all runs of the core suite so far: of the {} that it learned, "
                "{} ({}) is left at the end."
            ).format(_name(first), mean(value(first, LEARNED)), mean(kept), ends(kept))
        ]
    least = min(
        (entry for entry in ranked if entry.metrics[LOST].rank),
        key=lambda entry: (entry.metrics[LOST].mean or 0.0, entry.name),
        default=None,
    )
    sentences = [
        Markup("{} leads with {} ({}). {}").format(
            _name(first), mean(kept), ends(kept), _certainty(board, ranked, first, FINAL, "better than")
        )
    ]
    if least is not None:
        lost = value(least, LOST)
        certainty = _certainty(board, ranked, least, LOST, "less than")
        sentences.append(
            Markup("Of those that learned, {} forgets least: {} ({}). {}").format(
                _name(least), mean(lost), ends(lost), certainty
            )
        )
    return sentences


def _certainty(
    board: CoreBoard, ranked: Sequence[CoreEntry], first: CoreEntry, metric: str, relation: str
) -> Markup:
    """Whether the test over all pairs separates a method from each other one."""
    pairs = {entry.name: board.pair(metric, first.name, entry.name) for entry in ranked if entry != first}
    compared = {name: pair for name, pair in pairs.items() if pair}
    if not compared:
        return Markup("No other method is compared with it.")
    tied = [
        entry for entry in ranked if entry.name in compared and compared[entry.name].verdict != "separated"
    ]
    early = all(pair.exploratory for pair in compared.values())
    note = Markup(' (<a href="metrics.html#core">exploratory</a>)') if early else ""
    if not tied:
        return Markup("That is significantly {} every other method{}.").format(relation, note)
    *others, last = [short(entry.title, 40) for entry in tied]
    names = f"{', '.join(others)} and {last}" if others else last
    if len(tied) > MOST_NAMED:
        names = f"{len(tied)} of {count(len(compared), 'other method')}"
    if len(tied) == len(compared):
        return Markup("The lead is not certain: {} {} not separated from it.").format(
            names, "is" if len(tied) == 1 else "are"
        )
    return Markup("That is significantly {} all but {}{}.").format(relation, names, note)


def _name(entry: CoreEntry) -> Markup:
    return Markup("<strong><bdi>{}</bdi></strong>").format(short(entry.title, 40))


SIDE, LEFT, TOP, BOTTOM = 400.0, 46.0, 16.0, 44.0
"""Side of the square of the figure, and the space around it for labels."""
CHARACTER, LINE = 6.4, 13.0
"""About the width and height of a label's character."""
MAX_LABEL = 22


def figure(entries: Sequence[CoreEntry], references: Sequence[CoreReference] = ()) -> Markup:
    """Learned (x) against kept at the end (y): a point per method with both intervals.

    On the diagonal nothing is lost; the best corner is at the top right. Empty without a ranked method.
    Entries are best first; those without a score are left out. References are drawn as levels.
    """
    shown = [entry for entry in entries if entry.metrics[FINAL].mean is not None]
    if not shown:
        return Markup("")
    reach = [end for entry in shown for name in (FINAL, LEARNED) for end in _reach(value(entry, name))]
    reach += [each.value.mean or 0.0 for each in references]
    x = scale_around(reach, LEFT, LEFT + SIDE, always=())
    y = scale_around(reach, TOP + SIDE, TOP, always=())
    parts = [_axes(x, y), _diagonal(x, y)]
    for each in references:
        level = y.at(each.value.mean or 0.0)
        parts.append(stroke(x.start, level, x.end, level, "way"))
        parts.append(text("label way", x.start + 6, level - 5, str(escape(each.title))))
    places = [(x.at(value(entry, LEARNED).mean or 0), y.at(value(entry, FINAL).mean or 0)) for entry in shown]
    for number, (entry, (across, up)) in reversed(list(enumerate(zip(shown, places, strict=True)))):
        learned, kept = value(entry, LEARNED), value(entry, FINAL)
        kind = "unranked" if not entry.ranked else "other" if number else "first"
        if learned.ends and kept.ends:
            parts.append(stroke(x.at(learned.ends[0]), up, x.at(learned.ends[1]), up, f"whisker {kind}"))
            parts.append(stroke(across, y.at(kept.ends[0]), across, y.at(kept.ends[1]), f"whisker {kind}"))
        title = f"{entry.title} ({entry.name}): learned {mean(learned)}, kept {mean(kept)}"
        parts.append(
            f'<circle class="method {kind}" cx="{px(across)}" cy="{px(up)}" r="5.5">'
            f"<title>{escape(title)}</title></circle>"
        )
    parts += _labels(shown, places)
    label = "; ".join(
        f"{short(entry.title, 40)}: learned {mean(value(entry, LEARNED))}, kept {mean(value(entry, FINAL))}"
        for entry in shown
    )
    width, height = px(LEFT + SIDE + 8), px(TOP + SIDE + BOTTOM)
    return picture("plane", width, height, f"Learned against kept. {label}", "".join(parts))


def _reach(interval: MetricValue) -> tuple[float, ...]:
    return interval.ends or (interval.mean or 0.0,)


def _axes(x: Scale, y: Scale) -> str:
    parts = []
    for mark in x.ticks(5):
        parts.append(stroke(x.at(mark), y.start, x.at(mark), y.end, "level"))
        parts.append(stroke(x.start, y.at(mark), x.end, y.at(mark), "level"))
        parts.append(text("tick", x.at(mark), y.start + 16, tick_label(mark)))
        parts.append(text("tick side", x.start - 7, y.at(mark) + 3.5, tick_label(mark)))
    parts.append(text("axis", (x.start + x.end) / 2, y.start + 36, "learned: score right after the training"))
    middle = px((y.start + y.end) / 2)
    parts.append(
        f'<text class="axis" transform="translate(12 {middle}) rotate(-90)">kept: score at the end</text>'
    )
    return "".join(parts)


def _diagonal(x: Scale, y: Scale) -> str:
    """The line where nothing is lost, and the corner where everybody wants to be."""
    corner = f"M{px(x.end - 74)} {px(y.end)}H{px(x.end)}V{px(y.end + 74)}Z"
    at = (x.start + 0.3 * (x.end - x.start), y.start - 0.3 * (y.start - y.end) - 6)
    return (
        f'<path class="corner" d="{corner}"/>'
        + stroke(x.start, y.start, x.end, y.end, "diagonal")
        + f'<text class="axis" transform="translate({px(at[0])} {px(at[1])}) rotate(-45)">nothing lost</text>'
        + text("axis best", x.end - 8, y.end + 18, "best")
    )


def _labels(entries: Sequence[CoreEntry], places: Sequence[tuple[float, float]]) -> list[str]:
    """The names beside their points, where they cover neither a point nor an earlier name."""
    taken = [(across - 7, up - 7, across + 7, up + 7) for across, up in places]
    parts = []
    for entry, (across, up) in zip(entries, places, strict=True):
        name = short(entry.name, MAX_LABEL)
        width = CHARACTER * len(name)
        for line, start in product((-8, 17, -21, 30), (9, -9 - width, -width / 2)):
            box = (across + start, up + line - LINE + 3, across + start + width, up + line + 3)
            inside = box[0] > LEFT and box[2] < LEFT + SIDE and box[1] > TOP and box[3] < TOP + SIDE
            if inside and not any(_overlap(box, other) for other in taken):
                taken.append(box)
                parts.append(text("label", across + start, up + line, str(escape(name))))
                break
    return parts


def _overlap(box: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
