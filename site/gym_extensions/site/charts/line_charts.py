"""Line charts: the scores of every task over the sequence, training curves, and performance profiles.

A performance profile is the share of runs and tasks that score above each value. Source: Agarwal et al., Deep
RL at the Edge of the Statistical Precipice, NeurIPS 2021.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import date
from itertools import pairwise
from statistics import fmean

from markupsafe import Markup, escape

from gym_extensions.metrics.formulas import FINAL
from gym_extensions.scoring.ranking.boards import CoreRow
from gym_extensions.site import board_views, submission_results
from gym_extensions.site.charts import svg
from gym_extensions.site.text import fixed, grouped, short, variation

X, Y = (34.0, 200.0), (100.0, 10.0)
"""Left and right, bottom and top of a panel."""
MARGIN = 8
MOST_POINTS = 80
"""Points of a training curve: one in two pixels."""
UNITS = 2
"""Units per pixel of lines in panels: whole numbers of half pixels take half the bytes of coordinates."""


def line_chart(
    lines: Sequence[Sequence[tuple[float, float]]],
    x: svg.Scale,
    y: svg.Scale,
    label: str,
    *,
    bold: Sequence[tuple[float, float]] = (),
    since: float | None = None,
    levels: Sequence[float] = (),
) -> Markup:
    """The chart as an ``svg`` element.

    Args:
        lines: thin lines, as points (x, y).
        x: horizontal scale.
        y: vertical scale.
        label: the chart in words.
        bold: the bold line, with a dot per point.
        since: the area left of this x is shaded, and the dot at it is large.
        levels: horizontal lines, labelled where labels do not overlap, the first ones first.
    """
    body = _ground(x, y, since, dict.fromkeys(levels), levels)
    body += [f'<path class="thin" d="{_path(line, x, y)}"/>' for line in lines if line]
    if bold:
        body.append(f'<path class="bold" d="{_path(bold, x, y)}"/>')
        start, *ways = _ways(bold, x, y)
        stops = "".join(f"m{way}h0" for way in ways).replace(" -", "-")
        body.append(f'<path class="stops" d="M{start}h0{stops}"/>')
        body += [svg.disc("at", x.at(at), y.at(value), 4) for at, value in bold if at == since]
    return svg.picture("panel", x.end + MARGIN, max(y.start, y.end) + MARGIN, label, "".join(body))


def _ground(
    x: svg.Scale, y: svg.Scale, since: float | None, levels: Iterable[float], labels: Iterable[float]
) -> list[str]:
    """What is below the lines: the shaded part, levels, and the labels that do not overlap."""
    top, height = svg.px(min(y.start, y.end)), svg.px(abs(y.end - y.start))
    body = []
    if since is not None:
        width = svg.px(x.at(since) - x.start)
        body.append(
            f'<rect class="before" x="{svg.px(x.start)}" y="{top}" width="{width}" height="{height}"/>'
        )
    ways = (f"M{svg.px(x.start)} {svg.px(y.at(level))}H{svg.px(x.end)}" for level in levels)
    body.append(f'<path class="level" d="{"".join(ways)}"/>')
    return body + [
        svg.text("tick side", x.start - 4, y.at(each) + 3, svg.tick_label(each))
        for each in svg.apart(labels, y)
    ]


def _path(line: Sequence[tuple[float, float]], x: svg.Scale, y: svg.Scale) -> str:
    """The path of a line."""
    start, *ways = _ways(line, x, y)
    way = f"l{' '.join(ways)}" if ways else "h0"
    return f"M{start}{way}".replace(" -", "-")


def _ways(line: Sequence[tuple[float, float]], x: svg.Scale, y: svg.Scale) -> list[str]:
    """The first point of a line, then the way to each further one, in halves of a pixel."""
    columns, rows = zip(*line, strict=True)
    places = zip(x.each_at(columns), y.each_at(rows), strict=True)
    corners = [(round(UNITS * across), round(UNITS * up)) for across, up in places]
    steps = ((right - left, low - top) for (left, top), (right, low) in pairwise([(0, 0), *corners]))
    return [f"{across} {up}" for across, up in steps]


def histories(result: submission_results.SubmissionResult) -> Iterator[tuple[Markup, str, Markup]]:
    """Per task its title, unit and score after every stage: a line per run, the mean bold.

    Tasks with an expert share one scale of normalized returns. An open task has a scale of raw returns, which
    is its unit. The trained stage is marked.
    """
    scores = [result.detail.scores(at) for at in range(len(result.tasks))]
    shared = svg.scale_around((score for rows in scores if rows for row in rows for score in row), *Y)
    x = svg.Scale(0, len(result.tasks), *X)
    for at, (name, rows) in enumerate(zip(result.tasks, scores, strict=True)):
        returns = [[stage[at] for stage in run] for run in result.stage_matrices]
        means = [stage[at].mean_return if rows is None else stage[at].mean for stage in result.stages]
        mean = [(float(stage), value) for stage, value in enumerate(means) if value is not None]
        unit, y, digits = "", shared, 2
        levels: tuple[float, ...] = (0.0, 1.0, max(shared.ticks(4)))
        if rows is None:
            raw = [value for run in returns for value in run]
            unit = f"raw return{' (open)' if name in result.open_tasks else ''}"
            y, digits, levels = svg.scale_around(raw, *Y, always=()), 0, (min(raw), max(raw))
        shown = [fixed(mean[stage][1], digits) for stage in (0, at + 1, -1)]
        label = f"{name}: {shown[0]} untrained, {shown[1]} right after its training, {shown[2]} at the end"
        lines = [[(float(stage), value) for stage, value in enumerate(run)] for run in rows or returns]
        drawing = line_chart(lines, x, y, label, bold=mean, since=float(at + 1), levels=levels)
        yield variation(name, result.tasks), unit, drawing


def curves(result: submission_results.SubmissionResult) -> Iterator[tuple[Markup, str, Markup]]:
    """Per task with training curves its title, its steps with the first return beside the floor, and raw
    returns over steps. The first return is the mean over runs of the first point. One scale per group."""
    points = [point for curve in result.detail.curves for point in curve.points]
    if not points:
        return
    steps, values = zip(*points, strict=True)
    floors = {task: known.floor for task, known in result.detail.reference.items() if known.floor is not None}
    x = svg.Scale(0, max(steps) or 1.0, *X)
    y = svg.scale_around((*values, *floors.values()), *Y, always=())
    for task in result.tasks:
        lines = [curve.points for curve in result.detail.curves if curve.task == task and curve.points]
        if lines:
            final = ", ".join(fixed(line[-1][1], 0) for line in lines)
            label = f"{task}: training returns, at the end {final}"
            floor = floors.get(task, min(values))
            drawing = line_chart(list(map(_means, lines)), x, y, label, levels=(floor, max(values)))
            first = fixed(fmean(line[0][1] for line in lines), 0)
            facts = f"{grouped(int(max(steps)))} steps, first {first}"
            facts += f", floor {fixed(floor, 0)}" if task in floors else ""
            yield variation(task, result.tasks), facts, drawing


def _means(line: submission_results.Points) -> submission_results.Points:
    """The line; of one with more than ``MOST_POINTS``, the means of as many neighbours as needed."""
    size = -(-len(line) // MOST_POINTS)
    if size < 2:
        return line
    parts = [line[at : at + size] for at in range(0, len(line), size)]
    return tuple((fmean(x for x, _ in part), fmean(y for _, y in part)) for part in parts)


LINE_STYLES = 6
"""Number of line styles in the style sheet, and of lines in a chart."""


def panels(rows: Sequence[board_views.Row]) -> list[tuple[Markup, Markup]]:
    """Title and chart of every task that has scores, with a line per submission, on one scale."""
    results = [row.result for row in rows]
    scores = [value for result in results for stage in result.stages for value in stage]
    means = [value.mean for value in scores if value.mean is not None]
    if not means:
        return []
    tasks, untrained = results[0].tasks, results[0].stages[0]
    x, y = svg.Scale(0, len(tasks), *X), svg.scale_around(means, *Y)
    charts = []
    for at, task in enumerate(tasks):
        if untrained[at].mean is None:
            continue
        body = _ground(x, y, at + 1, (0.0, 1.0), (0.0, 1.0, *reversed(y.ticks(4))))
        labels = []
        for number, row in reversed(list(enumerate(rows, 1))):
            values = list(enumerate(stage[at] for stage in row.result.stages))
            mean = [(float(stage), value.mean) for stage, value in values if value.mean is not None]
            low = [(float(stage), value.ends[0]) for stage, value in values if value.ends]
            high = [(float(stage), value.ends[1]) for stage, value in values if value.ends]
            if low:
                around = svg.points([*low, *reversed(high)], x, y)
                body.append(f'<polygon class="band p{number}" points="{around}"/>')
            body.append(f'<polyline class="line p{number}" points="{svg.points(mean, x, y)}"/>')
            after, end = mean[at + 1][1], mean[-1][1]
            name = f"{short(row.submission.title)} ({row.submission.name})"
            labels.append(f"{name}: {fixed(after)} right after its training, {fixed(end)} at the end")
        drawing = svg.picture("panel", 208, 108, "; ".join(reversed(labels)), "".join(body))
        charts.append((variation(task, tasks), drawing))
    return charts


PROFILE_X, PROFILE_Y = (40.0, 372.0), (164.0, 24.0)
"""Left and right, bottom and top of a profile."""
RECORDS_X, RECORDS_Y = (34.0, 346.0), (130.0, 14.0)
"""The same of the best scores over time."""
DESCRIBED = (0.0, 0.5, 1.0, 2.0)
"""The scores whose shares the description names, where the profile has them."""


def described(profile: submission_results.Points) -> str:
    """The profile in words, for example ``above 0: 100 %, above 0.5: 60 %``."""
    shares = [(at, share) for at, share in profile if at in DESCRIBED]
    return ", ".join(f"above {svg.tick_label(at)}: {100 * share:.0f}\u202f%" for at, share in shares)


def profile(result: submission_results.SubmissionResult) -> Markup:
    """The profile of one submission on one group, which has one."""
    return _profiles([("", result.profile)], described(result.profile))


def board_profile(rows: Sequence[board_views.Row]) -> Markup:
    """The profiles of submissions on one scale; the first one is drawn last, above the others."""
    titled = [(row.submission.title, row.result.profile) for row in rows]
    return _profiles(titled, "; ".join(f"{title}: {described(each)}" for title, each in titled))


def _profiles(lines: Sequence[tuple[str, submission_results.Points]], label: str) -> Markup:
    first, last = lines[0][1][0][0], max(each[-1][0] for _, each in lines)
    x, y = svg.Scale(first, last, *PROFILE_X), svg.Scale(0.0, 1.0, *PROFILE_Y)
    body = [svg.stroke(x.start, y.at(share), x.end, y.at(share), "level") for share in (0.0, 0.5, 1.0)]
    body += [svg.text("tick side", x.start - 5, y.at(at / 100) + 3, f"{at}\u202f%") for at in (0, 50, 100)]
    body += [
        svg.stroke(x.at(score), y.start, x.at(score), y.end, f"grid {name}")
        for score, name in ((0.0, "floor"), (1.0, "expert"))
    ]
    body += [
        svg.text(f"tick{' key' if score in {0, 1} else ''}", x.at(score), y.start + 14, svg.tick_label(score))
        for score in x.ticks()
    ]
    body.append(svg.text("tick name", 0, 10, "share of runs and tasks above the score"))
    body.append(svg.text("tick side", x.end, y.start + 29, "normalized score at the end"))
    for number, (title, each) in reversed(list(enumerate(lines, 1))):
        named = f"<title>{escape(title)}</title>" if title else ""
        # Points between two others of the same share are left out.
        inner = range(1, len(each) - 1)
        level = {at for at in inner if each[at - 1][1] == each[at][1] == each[at + 1][1]}
        through = svg.points([point for at, point in enumerate(each) if at not in level], x, y)
        body.append(f'<polyline class="line p{number}" points="{through}">{named}</polyline>')
    return svg.picture("profile", 384, 196, label, "".join(body))


def records(best: Mapping[str, Sequence[tuple[str, CoreRow]]], until: str) -> Markup:
    """A step line per list, by its title: its best score from each YYYY-MM-DD on, oldest first."""
    days = {day: date.fromisoformat(day).toordinal() for steps in best.values() for day, _ in steps}
    x = svg.Scale(min(days.values()), max(date.fromisoformat(until).toordinal(), *days.values()), *RECORDS_X)
    means = {row.name: row.metrics[FINAL.name].mean or 0.0 for steps in best.values() for _, row in steps}
    y = svg.scale_around(means.values(), *RECORDS_Y, always=(0.0,))
    body = _ground(x, y, None, y.ticks(4), y.ticks(4))
    body += [svg.text("tick", x.start, y.start + 16, min(days)), svg.text("tick", x.end, y.start + 16, until)]
    said = []
    for number, (title, steps) in enumerate(best.items(), 1):
        at = [(x.at(days[day]), y.at(means[row.name])) for day, row in steps]
        way = "".join(f"H{svg.px(across)}V{svg.px(up)}" for across, up in at)
        body.append(
            f'<path class="line p{number}" d="M{svg.px(at[0][0])} {svg.px(at[0][1])}{way}H{x.end:g}"/>'
        )
        texts = [fixed(means[row.name]) for _, row in steps]
        beside = -6 if number == 1 else 14  # above its line, or below it
        body += [svg.text("tick name", at[i][0] + 4, at[i][1] + beside, text) for i, text in enumerate(texts)]
        said += [f"{title}: {text} since {day}" for text, (day, _) in zip(texts, steps, strict=True)]
    return svg.picture("profile", 384, 150, "; ".join(said), "".join(body))
