"""The templates with their filters and globals, and the digest of all code that pages depend on."""

from __future__ import annotations

from functools import cache
from importlib import metadata
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from gym_extensions import catalog, references, scoring, submissions
from gym_extensions.metrics.formulas import BY_NAME, COLUMNS, CORE_METRICS, FORGETTING, LEARNING
from gym_extensions.scoring.output import highlights
from gym_extensions.scoring.scorecard import PAPER_COLUMNS
from gym_extensions.site import FOLDER, paths, submission_facts, submission_results, tables, text
from gym_extensions.site.board_views import missing_reasons
from gym_extensions.site.charts import landscapes, profiles, strips, task_curves, task_pictures
from gym_extensions.site.charts.task_pictures import PICTURES
from gym_extensions.site.output import digest
from gym_extensions.site.play import stroboscopes
from gym_extensions.site.play.assets import play_group_link
from gym_extensions.submissions.review import REPORTED

LIBRARIES = ("jinja2", "markupsafe", "msgspec", "numpy", "scipy")


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
        auto_reload=False,
    )
    templates.filters.update(
        fixed=text.fixed,
        grouped=text.grouped,
        readable=text.readable,
        short=text.short,
        task=text.task,
    )
    templates.globals.update(
        paths=paths,
        text=text,
        submission_facts=submission_facts,
        tables=tables,
        results=submission_results,
        landscape_charts=landscapes,
        profiles=profiles,
        task_curves=task_curves,
        strips=strips,
        task_pictures=task_pictures,
        stroboscopes=stroboscopes,
        board_columns=COLUMNS,
        core_metrics=CORE_METRICS,
        forgetting=highlights.FORGETTING,
        largest_change=highlights.largest_change,
        metrics=BY_NAME,
        FORGETTING=FORGETTING.name,
        LEARNING=LEARNING.name,
        missing_reasons=missing_reasons,
        paper_columns=PAPER_COLUMNS,
        reported=REPORTED,
        play_group_link=play_group_link,
    )
    return templates


@cache
def source_digest() -> str:
    """A digest of the code, the templates and the libraries that scorecards and pages are made with."""
    folders = [
        FOLDER,
        PICTURES,
        *(Path(path) for package in (catalog, references, scoring, submissions) for path in package.__path__),
    ]
    files = sorted(
        file
        for folder in folders
        for file in folder.rglob("*")
        if file.suffix in {".py", ".html", ".css", ".csv", ".js", ".json", ".png", ".svg", ".webp", ".xml"}
    )
    versions = [f"{name} {metadata.version(name)}".encode() for name in LIBRARIES]
    return digest(*versions, *(part for file in files for part in (file.name.encode(), file.read_bytes())))
