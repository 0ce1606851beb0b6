"""The metrics of one entry as CSV."""

from __future__ import annotations

import csv
import io

from gym_extensions.scoring.output.spreadsheet import no_formula
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.views.trial import group_trials, suite_trials

COLUMNS = ("name", "trust", "group", "protocol", "budget", "runs", "metric", "mean", "low", "high", "why")
"""Those of ``score --csv``."""


def metrics_csv(card: Scorecard) -> str:
    """One row per group or suite, protocol and metric: floats by ``repr``, missing values empty."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for trial in (*group_trials(card), *suite_trials(card)):
        runs = len(trial.runs) if trial.detail else ""
        for name, value in trial.metrics.items():
            low, high = value.ends or ("", "")
            mean = "" if value.mean is None else value.mean
            facts = (card.name, card.trust or "", trial.group, trial.protocol, trial.score.budget)
            texts = (*map(no_formula, facts), runs, name)
            writer.writerow((*texts, mean, low, high, no_formula(value.why)))
    return out.getvalue()
