"""Writes docs/findings.md and its figures from the committed submissions: ``make findings``.

Every number and verdict is computed. The text is in ``page.md.jinja``; ``tables.py`` says what is compared.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from gym_extensions import results
from gym_extensions.catalog.groups import GROUPS, SUITES
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.files import write_text
from gym_extensions.metrics.formulas import BY_NAME
from gym_extensions.scoring import score_folder
from gym_extensions.scoring.output.board_frames import core_frame, core_pairs_frame
from gym_extensions.scoring.pipeline import make_scorer, valid_scorecards
from gym_extensions.scoring.ranking.core_board import IN_OTHER_WAYS, core_board
from gym_extensions.scoring.submission.suites import core_logs, core_score, retention
from gym_extensions.site.pages.core import FIRST, figure
from gym_extensions.site.pages.landscapes import View
from gym_extensions.site.text import fixed, rank
from gym_extensions.submissions.landscapes import best, landscapes_of
from gym_extensions.submissions.review import TRAINED_HERE
from tools.findings import bases, claims, hypotheses, tables
from tools.findings.figures import draw_groups, draw_retention, write_picture
from tools.findings.orders import orders, turned
from tools.findings.tables import COLUMNS, CORE, FINAL, FINE_TUNING, LEARNED, LOST, REPLAY

ROOT = Path(__file__).resolve().parents[2]
FOLDER, PAGE = ROOT / "docs" / "findings", ROOT / "docs" / "findings.md"
IMAGES = ROOT / "docs" / "images"
NOT_COMPARED = {"random", "zero", *IN_OTHER_WAYS, "trpo-2017", "trpo-2017-paper", "trpo-2017-paper-hopper"}


def of_runs(folder: Path, metric: str = LOST) -> dict[str, Sequence[float]]:
    """A metric of every run of a submission, by group id."""
    groups = score_folder(folder).groups
    logs = {group: protocols.get("sequential") for group, protocols in groups.items()}
    return {group: log.metrics[metric].runs for group, log in logs.items() if log and metric in log.metrics}


def landscape(submissions: Path, *names: str, group: str = "hopper-gravity") -> View:
    """The landscape on a group of the first of these submissions that has one."""
    found = {folder.name: landscapes_of(folder) for folder in submissions.iterdir() if folder.is_dir()}
    shown = next(each for name in names if (each := found[name].get(GROUPS[group].id)))
    return View(GROUPS[group], shown, best(found))


def main() -> None:
    """Writes the page and its figures."""
    submissions = ROOT / "submissions"
    cards = list(valid_scorecards(submissions, make_scorer(only=("core",))).values())
    board = core_board(cards)
    own = [replace(card, trained={}) for card in cards]  # the runs of the first edition
    own = [card for card in own if all(log.level != TRAINED_HERE for log in core_logs(card).values())]
    before = core_board([replace(card, core=core_score(card)) for card in own])
    core, metrics = core_frame(board), results.metrics(submissions)
    pairs = core_pairs_frame(board)
    methods = tables.methods(core, pairs)
    names = [name for name in core["name"] if name not in NOT_COMPARED]
    finals = dict(tables.by_group(metrics, names, FINAL))
    groups = tables.fine_tuning(metrics, of_runs(submissions / FINE_TUNING))
    learned = [row for row in groups if row.is_learned]
    other_ways = [tables.Method(row, {}) for _, row in core[core["name"].isin(IN_OTHER_WAYS)].iterrows()]
    assert board is not None
    write_picture(figure(board.rows[:FIRST], board.references), "plane", IMAGES / "overview.svg")
    draw_groups(list(finals.items()), [group.name for group in CORE], FOLDER / "groups.svg")
    evaluations = results.evaluations(submissions / FINE_TUNING)
    scores = tables.as_scores(evaluations)
    draw_retention(scores, tables.most_forgotten(learned), FOLDER / "retention.svg")
    (axis,) = landscape(submissions, tables.of_edition("cloning", board.edition), "cloning").axes
    write_picture(axis.large, "landscape", IMAGES / "landscape.svg")
    policies = results.policies([submissions / name for name in names])
    policies = policies[policies["group"].isin([group.id for group in CORE])]
    trained = set(metrics[metrics["name"] == FINE_TUNING]["group"])
    scored = {row.group.name for row in groups}
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).parent), undefined=StrictUndefined, trim_blocks=True
    )
    templates.globals.update(
        fmt=partial(fixed, digits=2), rank=rank, Value=tables.Value, percent=tables.percent
    )
    templates.globals.update(pair_of=partial(tables.against, pairs, FINAL), sides=tables.sides)
    text = templates.get_template("page.md.jinja").render(
        budget=STANDARD_BUDGET,
        fine_tuning=FINE_TUNING,
        core=[group.name for group in CORE],
        methods=methods,
        descriptions={card.name: card.manifest.description for card in cards if card.manifest},
        improvements=tables.improvements(methods, {card.name: card for card in cards}),
        other_ways=other_ways,
        incomplete=core[~core["ranked"] & core["name"].isin(names)].to_dict("records"),
        VERDICTS={"separated": "**significant**", "equivalent": "equivalent", "open": "not significant"},
        LEARNED=LEARNED,
        FINAL=FINAL,
        LOST=LOST,
        finals=finals.items(),
        losses=tables.by_group(metrics, names, LOST),
        learned=learned,
        unlearned=[row for row in groups if not row.is_learned],
        without_score=[g.name for g in GROUPS.values() if g.id in trained and g.name not in scored],
        suites=[
            (name, [tables.value(metrics, FINE_TUNING, name, metric) for metric in COLUMNS])
            for name in SUITES
            if name in trained
        ],
        open_tasks={name: each for name, each in tables.open_tasks().items() if name in scored},
        transfer_titles=[BY_NAME[name].title for name in tables.TRANSFERS],
        transfers=tables.transfers(metrics),
        practice=tables.practice_by_other_runs(evaluations),
        replay={
            metric: tables.replay({name: of_runs(submissions / name, metric) for name in REPLAY})
            for metric in (LEARNED, FINAL, LOST)
        },
        tuning={card.name: card.manifest.tuning for card in cards if card.manifest},
        variants=board.variants,
        kept={
            group: tables.Value.of(retention([log], len(log.runs)))
            for group, logs in score_folder(submissions / FINE_TUNING).groups.items()
            if (log := logs.get("sequential")) and log.metrics[LOST].runs
        },
        edition=board.edition,
        withdrawn=hypotheses.withdrawn(before, board) if before and board.edition > 1 else [],
        hypotheses=hypotheses.verdicts(board, {card.name: claims.runs_of(card, LOST) for card in cards}),
        **claims.facts(board, {card.name: card for card in cards}),
        positions={
            group.name: claims.positions(results.scores(submissions / FINE_TUNING, group, stage=-1))
            for group in CORE
            if group.id in SUITES["gravity"]
        },
        orders=orders(metrics, results.order_effects(submissions)),
        turned=turned(cards),
        bases=bases.base_by_addition(
            {
                card.name: {group: log.metrics[FINAL].runs for group, log in core_logs(card).items()}
                for card in cards
            }
        ),
        BASES=bases.BASES,
        BASE_GROUPS=[name.rpartition("-v")[0] for name in bases.GROUPS],
        landscapes=tables.between_and_beyond(results.landscapes([submissions / name for name in names])),
        predictors=tables.predictors(policies),
        networks=tables.network_changes(policies),
        missing={
            group.name: [name for name, values in finals.items() if math.isnan(values[place].mean)]
            for place, group in enumerate(CORE)
        },
        never=[group.name for group in GROUPS.values() if group.id not in trained],
    )
    write_text(PAGE, text + "\n")
