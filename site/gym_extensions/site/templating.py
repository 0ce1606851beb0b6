"""The templates with their filters and globals, and the digest of all code that pages depend on."""

from __future__ import annotations

from functools import cache
from importlib import metadata
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from gym_extensions import catalog, rollouts, scoring
from gym_extensions.scoring.metrics.definitions import BY_NAME
from gym_extensions.scoring.metrics.paper_table import COLUMNS as PAPER_COLUMNS
from gym_extensions.scoring.scorecard import highlights
from gym_extensions.scoring.scorecard.model import REPORTED
from gym_extensions.site import addresses
from gym_extensions.site.charts import (
    band_chart,
    heatmap,
    performance_profile,
    small_multiples,
    strip_plot,
)
from gym_extensions.site.charts.speed_bar import speed_bar
from gym_extensions.site.exports.commands import commands
from gym_extensions.site.motion.episode_dots import episode_dots
from gym_extensions.site.motion.stroboscope import stroboscopes
from gym_extensions.site.output import digest
from gym_extensions.site.tables import cells
from gym_extensions.site.tasks.gravity_arrows import gravity_arrows
from gym_extensions.site.tasks.reference_dots import reference_dots
from gym_extensions.site.text import labels, markdown, names, numbers, values
from gym_extensions.site.views import pictures, trial
from gym_extensions.site.views.board import missing_reasons
from gym_extensions.site.views.board_row import COLUMNS

FOLDER = Path(__file__).parent
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
        fixed=numbers.fixed,
        grouped=numbers.grouped,
        inline=markdown.inline,
        readable=numbers.readable,
        short=names.short,
        task=names.task,
    )
    templates.globals.update(
        addresses=addresses,
        band_chart=band_chart,
        board_columns=COLUMNS,
        cells=cells,
        commands=commands,
        episode_dots=episode_dots,
        forgetting=highlights.FORGETTING,
        gravity_arrows=gravity_arrows,
        group_trials=trial.group_trials,
        heatmap=heatmap,
        labels=labels,
        largest_change=highlights.largest_change,
        metrics=BY_NAME,
        missing_reasons=missing_reasons,
        names=names,
        numbers=numbers,
        paper_columns=PAPER_COLUMNS,
        performance_profile=performance_profile,
        pictures=pictures,
        reference_dots=reference_dots,
        reported=REPORTED,
        separate_groups=trial.separate_groups,
        small_multiples=small_multiples,
        speed_bar=speed_bar,
        strip_plot=strip_plot,
        stroboscopes=stroboscopes,
        suite_trials=trial.suite_trials,
        table_digits=trial.table_digits,
        values=values,
    )
    return templates


@cache
def source_digest() -> str:
    """A digest of the code, the templates and the libraries that scorecards and pages are made with."""
    folders = [FOLDER, *(Path(path) for package in (catalog, rollouts, scoring) for path in package.__path__)]
    files = sorted(
        file
        for folder in folders
        for file in folder.rglob("*")
        if file.suffix in {".py", ".html", ".css", ".csv", ".js", ".json", ".png", ".svg", ".webp"}
    )
    versions = [f"{name} {metadata.version(name)}".encode() for name in LIBRARIES]
    return digest(*versions, *(part for file in files for part in (file.name.encode(), file.read_bytes())))
