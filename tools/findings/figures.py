"""The figures of the findings page, as SVG files whose bytes depend on the data alone."""

import re
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path

import matplotlib
import pandas as pd
from matplotlib.figure import Figure

from gym_extensions import site
from gym_extensions.files import write_text
from gym_extensions.results.plots import plot_retention
from gym_extensions.scoring.group_score import PaperRow
from gym_extensions.scoring.submission.stages import task_name
from tools.findings.tables import Value

matplotlib.rcParams |= {"svg.hashsalt": "gym-extensions", "svg.fonttype": "none", "font.size": 9}
COLUMNS = 2


def draw_groups(rows: Sequence[tuple[str, Sequence[Value]]], groups: Sequence[str], path: Path) -> None:
    """The final performance of every method with its interval, one panel per group."""
    figure = Figure(figsize=(12, 0.9 + 0.26 * len(rows)), layout="constrained")
    panels = figure.subplots(1, len(groups), sharey=True)
    for column, (group, axes) in enumerate(zip(groups, panels, strict=True)):
        for height, (_, values) in enumerate(rows):
            each = values[column]
            if each.is_known:
                axes.plot(
                    [each.low, each.high], [height, height], color="C0", linewidth=3, alpha=0.45, zorder=1
                )
            axes.plot(each.mean, height, "o", color="C0", markersize=4)
        axes.axvline(0, color="0.8", linewidth=0.8, zorder=0)
        axes.set_title(group, fontsize=8)
    panels[0].set_yticks(range(len(rows)), [name for name, _ in rows])
    panels[0].invert_yaxis()
    figure.supxlabel("score at the end (0 = floor, 1 = expert)", fontsize=9)
    _save(figure, path)


def draw_retention(frame: pd.DataFrame, groups: Sequence[str], path: Path) -> None:
    """The score on every task while the tasks are trained in order, one panel per group."""
    columns = min(COLUMNS, len(groups))
    rows = -(-len(groups) // columns)
    figure = Figure(figsize=(5.6 * columns, 2.8 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).flat
    for group, axes in zip(groups, panels, strict=False):  # in this order, zip takes no panel too many
        plot_retention(frame, group, ax=axes)
        axes.set(title=group, ylabel="mean score")
        lines, tasks = axes.get_legend_handles_labels()
        names = _without_common_words(tasks)  # the title names the body
        axes.legend(lines, names, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    for axes in panels:  # without a group
        axes.set_axis_off()
    _save(figure, path)


def write_picture(picture: str, name: str, path: Path) -> None:
    """A picture of a page as a file, with the rules of the style sheet for its class and its ticks."""
    static = site.FOLDER / "static"
    sheet = "".join((static / file).read_text("utf-8") for file in ("masthead.css", "style.css"))
    colours = re.search(r":root \{.*?\n\}\n@media [^{]*\{\n  :root \{.*?\n\}\n", sheet, re.DOTALL)
    assert colours is not None
    rules = re.findall(rf"^\.(?:{name}|tick)[ .].*\n", sheet, re.MULTILINE)
    size = r'xmlns="http://www.w3.org/2000/svg" width="\1" height="\2" viewBox="0 0 \1 \2"'
    head, body = re.sub(r'viewBox="0 0 (\S+) (\S+)"', size, str(picture)).split(">", 1)
    paper = '<rect width="100%" height="100%" fill="var(--paper)"/>'
    write_text(path, f"{head}>\n<style>\n{colours[0]}{''.join(rules)}</style>\n{paper}{body}\n")


def draw_reproduction(
    groups: Sequence[tuple[str, Sequence[PaperRow], Sequence[PaperRow]]], path: Path
) -> None:
    """The return right after training on a task (ring) and at the end (disc), printed and reproduced."""
    figure = Figure(figsize=(8.8, 2.8 * len(groups)), layout="constrained")
    panels = figure.subplots(len(groups), 1, squeeze=False).flat
    for (title, *sources), axes in zip(groups, panels, strict=True):
        for rows, label, color, shift in zip(
            sources, ("paper", "here"), ("0.45", "C0"), (-0.12, 0.12), strict=True
        ):
            for place, row in enumerate(rows):
                after, final = row.after_env_training, row.fully_trained
                assert after is not None and final is not None
                x = place + shift
                axes.plot([x, x], [after.mean, final.mean], color=color, linewidth=1.5)
                axes.plot(x, after.mean, "o", color=color, markerfacecolor="white")
                axes.plot(x, final.mean, "o", color=color, label=label if place == 0 else None)
        axes.set_xticks(
            range(len(sources[0])), _without_common_words([task_name(row.task) for row in sources[0]])
        )
        axes.set_title(title)
        axes.set_ylabel("return: ring after training\non the task, disc at the end")
        axes.legend(frameon=False)
    _save(figure, path)


def _without_common_words(tasks: Sequence[str]) -> list[str]:
    """The names without the words that all begin with; a name that is only these words stays whole."""
    words = [re.findall(r"[A-Z][^A-Z]*", task) for task in tasks]
    common = len(list(takewhile(lambda column: len(set(column)) == 1, zip(*words, strict=False))))
    return ["".join(each[common:]) or task for each, task in zip(words, tasks, strict=True)]


def _save(figure: Figure, path: Path) -> None:
    figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
