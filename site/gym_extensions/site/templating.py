"""The templates with their filters and globals."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from gym_extensions.metrics.formulas import BY_NAME, COLUMNS, CORE_METRICS, FORGETTING, LEARNING
from gym_extensions.scoring.output import highlights
from gym_extensions.scoring.scorecard import PAPER_COLUMNS
from gym_extensions.site import FOLDER, paths, submission_facts, submission_results, tables, text
from gym_extensions.site.board_views import missing_reasons
from gym_extensions.site.charts import landscapes, profiles, strips, task_curves, task_pictures
from gym_extensions.site.play import stroboscopes
from gym_extensions.site.play.assets import play_group_link
from gym_extensions.submissions.review import REPORTED


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
