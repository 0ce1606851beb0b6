"""Writes every page into a folder. The same document gives the same bytes."""

from __future__ import annotations

import posixpath
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from gym_extensions.errors import BenchError
from gym_extensions.scoring.metrics.definitions import BY_NAME
from gym_extensions.scoring.metrics.paper_table import COLUMNS as PAPER_COLUMNS
from gym_extensions.scoring.poses.files import PosesByGroup
from gym_extensions.scoring.scorecard.model import REPORTED, ScorecardDocument
from gym_extensions.site.charts import heatmap, performance_profile, small_multiples, strip_plot
from gym_extensions.site.charts.episode_dots import episode_dots
from gym_extensions.site.charts.speed_bar import speed_bar
from gym_extensions.site.charts.stroboscope import stroboscopes
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import pages
from gym_extensions.site.text import labels, names, numbers
from gym_extensions.site.views import losses, trial
from gym_extensions.site.views.board import missing_reasons
from gym_extensions.site.views.board_row import COLUMNS
from gym_extensions.site.views.watch import watch

FOLDER = Path(__file__).parent
MARK = ".gym-extensions-site"
"""A file that marks a built site, so that a build never replaces another folder."""


@cache
def environment() -> Environment:
    """The templates, compiled once. All values are escaped, and an unknown name is an error."""
    templates = Environment(
        loader=FileSystemLoader(FOLDER / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    templates.filters.update(
        fixed=numbers.fixed, grouped=numbers.grouped, readable=numbers.readable, task=names.task
    )
    templates.globals.update(
        board_columns=COLUMNS,
        episode_dots=episode_dots,
        group_trials=trial.group_trials,
        heatmap=heatmap,
        labels=labels,
        largest_loss=losses.largest_loss,
        matrix_digits=trial.matrix_digits,
        metrics=BY_NAME,
        missing_reasons=missing_reasons,
        names=names,
        nothing_to_forget=trial.nothing_to_forget,
        numbers=numbers,
        paper_columns=PAPER_COLUMNS,
        performance_profile=performance_profile,
        reported=REPORTED,
        small_multiples=small_multiples,
        speed_bar=speed_bar,
        strip_plot=strip_plot,
        stroboscopes=stroboscopes,
        suite_trials=trial.suite_trials,
        table_digits=trial.table_digits,
        watch=watch,
    )
    return templates


def files(document: ScorecardDocument, poses: PosesByGroup | None = None) -> Iterator[tuple[str, str]]:
    """Every file of the site as (path, text), in the order of the pages."""
    leaderboard = Leaderboard(document, poses or {})
    registry = pages()
    menu = [page for page in registry if page.path]
    templates = environment()

    def render(template: str, path: str, **values: object) -> str:
        relative = posixpath.relpath(".", posixpath.dirname(path) or ".")
        root = Markup("" if relative == "." else f"{relative}/")
        return templates.get_template(template).render(
            site=leaderboard, menu=menu, path=path, root=root, **values
        )

    for page in registry:
        yield from page.publish(leaderboard, render)
    for file in sorted((FOLDER / "static").iterdir()):
        yield f"static/{file.name}", file.read_text(encoding="utf-8")


def build(document: ScorecardDocument, out: Path, poses: PosesByGroup | None = None) -> Path:
    """Writes the site to ``out`` and returns the path of its index; a failed build leaves ``out`` unchanged.

    Args:
        document: the scorecards.
        out: the folder of the site.
        poses: the poses of entries, for their Watch panels; those of other results are not shown.

    Raises:
        BenchError: ``out`` exists, is not empty, and was not written by an earlier build.
    """
    if out.exists() and not (out / MARK).is_file() and not (out.is_dir() and not any(out.iterdir())):
        raise BenchError(
            "not-a-site",
            "It exists and does not contain a built site.",
            where=str(out),
            hint="Name a new or empty folder with --out.",
        )
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as scratch:
        new = Path(scratch) / "new"
        for path, text in [(MARK, ""), *files(document, poses)]:
            target = new / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(text.encode())
        if out.exists():
            out.replace(Path(scratch) / "old")
        new.replace(out)
    return out / "index.html"
