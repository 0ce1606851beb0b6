"""Builds every page into a folder: the same document gives the same bytes."""

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
from gym_extensions.scoring.metrics.paper_table import COLUMNS
from gym_extensions.scoring.scorecard.model import ScorecardDocument
from gym_extensions.site.charts import heatmap as heat
from gym_extensions.site.charts import performance_profile as profiles
from gym_extensions.site.charts import small_multiples as panels
from gym_extensions.site.charts import strip_plot as charts
from gym_extensions.site.page import Leaderboard, pages
from gym_extensions.site.text import labels as words
from gym_extensions.site.text import numbers as numerals
from gym_extensions.site.views import board as boards
from gym_extensions.site.views import trial as trials

HERE = Path(__file__).parent
MARK = ".gym-extensions-site"
"""A file that says the folder is ours, so that a build never replaces somebody's own folder."""


@cache
def environment() -> Environment:
    """The templates, compiled once: everything is escaped, and an unknown name is an error."""
    made = Environment(
        loader=FileSystemLoader(HERE / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters.update(
        fixed=numerals.fixed, grouped=numerals.grouped, ordinary=numerals.ordinary, task=words.task
    )
    made.globals.update(
        boards=boards,
        charts=charts,
        heat=heat,
        panels=panels,
        profiles=profiles,
        metrics=BY_NAME,
        paper_columns=COLUMNS,
        trials=trials,
        words=words,
        numerals=numerals,
    )
    return made


def files(document: ScorecardDocument) -> Iterator[tuple[str, str]]:
    """Every file of the site as (path, text), in the order of the pages."""
    leaderboard = Leaderboard(document)
    registry = pages()
    menu = [page for page in registry if page.path]
    templates = environment()

    def render(template: str, path: str, **values: object) -> str:
        root = posixpath.relpath(".", posixpath.dirname(path) or ".")
        address = Markup("" if root == "." else f"{root}/")
        return templates.get_template(template).render(
            site=leaderboard, menu=menu, here=path, root=address, **values
        )

    for page in registry:
        yield from page.publish(leaderboard, render)
    for path in sorted((HERE / "static").iterdir()):
        yield f"static/{path.name}", path.read_text(encoding="utf-8")


def build(document: ScorecardDocument, out: Path) -> Path:
    """Writes the site to ``out`` and gives the path of its index: all of it, or the folder stays as it was.

    Raises:
        BenchError: ``out`` exists and is not a folder that an earlier build has made.
    """
    if out.exists() and not (out / MARK).is_file() and not (out.is_dir() and not any(out.iterdir())):
        raise BenchError(
            "not-a-site",
            "This is there already, and no site was built in it.",
            where=str(out),
            hint="Name a new or empty folder with --out.",
        )
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as scratch:
        made = Path(scratch) / "new"
        for path, text in [(MARK, ""), *files(document)]:
            target = made / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(text.encode())
        if out.exists():
            out.replace(Path(scratch) / "old")
        made.replace(out)
    return out / "index.html"
