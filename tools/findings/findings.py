"""Writes docs/findings.md and its figures from the committed submissions: ``make findings``.

Every number and verdict is computed. The text is in ``page.md.jinja``; ``tables.py`` says what is compared.
"""

import math
import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from gym_extensions import results
from gym_extensions.catalog.groups import GROUPS, SUITES
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.metrics.formulas import BY_NAME
from gym_extensions.scoring.output.board_frames import core_frame, metrics_frame
from gym_extensions.scoring.pipeline import make_scorer, valid_scorecards
from gym_extensions.scoring.ranking.core_board import IN_OTHER_WAYS, core_board, lacking
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import core_logs, is_trained_here, retention
from gym_extensions.site.pages.core import FIRST, figure
from gym_extensions.site.pages.landscapes import View
from gym_extensions.site.text import fixed, rank
from gym_extensions.submissions.landscapes import best, landscapes_of
from gym_extensions.verification.git import Repository
from tools import ROOT
from tools.findings import bases, claims, editions, hypotheses, tables
from tools.findings.figures import draw_groups, draw_retention, write_picture
from tools.findings.orders import ends_by_task, orders, turned
from tools.findings.tables import COLUMNS, CORE, FINAL, FINE_TUNING, LEARNED, LOST, REPLAY, of_edition

FOLDER, PAGE = ROOT / "docs" / "findings", ROOT / "docs" / "findings.md"
IMAGES, README = ROOT / "docs" / "images", ROOT / "README.md"
RESULTS = re.compile(r"(?<=<!-- findings -->\n).*?(?=<!-- end -->)", re.DOTALL)
"""The part of the README that is written with the page."""
FIRST_EDITION, HYPOTHESES = FOLDER / "first-edition.json", FOLDER / "hypotheses.json"
NOT_COMPARED = {"random", "zero", *IN_OTHER_WAYS, "trpo-2017", "trpo-2017-paper", "trpo-2017-paper-hopper"}


def jinja() -> Environment:
    """The templates of the pages, which refuse a name that nothing defines."""
    here = FileSystemLoader(Path(__file__).parent)
    made = Environment(loader=here, undefined=StrictUndefined, trim_blocks=True)
    made.globals |= {"fmt": partial(fixed, digits=2), "rank": rank, "Value": tables.Value}
    made.globals |= {"percent": tables.percent, "sides": tables.sides}
    return made


def of_runs(card: Scorecard, metric: str = LOST) -> dict[str, Sequence[float]]:
    """A metric of every sequential run of a submission, by group id."""
    logs = {group: protocols.get("sequential") for group, protocols in card.groups.items()}
    return {group: log.metrics[metric].runs for group, log in logs.items() if log and metric in log.metrics}


def landscape(submissions: Path, *names: str, group: str = "hopper-gravity") -> View:
    """The landscape on a group of the first of these submissions that has one; ``BenchError`` without."""
    found = {folder.name: landscapes_of(folder) for folder in submissions.iterdir() if folder.is_dir()}
    for name in names:
        if shown := found.get(name, {}).get(GROUPS[group].id):
            return View(GROUPS[group], shown, best(found))
    hint = f"Run: gym-extensions maintain landscapes submissions/{names[0]} --groups {group}"
    raise BenchError("no-landscape", f"{names[0]} has no landscape.", str(submissions), hint)


def verdicts(cards: Mapping[str, Scorecard], is_early: bool) -> list[hypotheses.Verdict]:
    """The verdicts on the hypotheses: given once, with what is committed, and as stored from then on."""

    def give() -> list[hypotheses.Verdict]:
        return hypotheses.tested(cards, Repository(ROOT).fixed(ROOT, ["submissions", "scoring", "tools"]))

    is_open = not (is_early or HYPOTHESES.exists())
    return editions.stored(HYPOTHESES, hypotheses.Verdict, give, is_open=is_open)


def main() -> None:
    """Writes the page and its figures, the results of the README, and what an edition states for good."""
    submissions = ROOT / "submissions"
    cards = {folder.name: card for folder, card in valid_scorecards(submissions, make_scorer()).items()}
    board = core_board(list(cards.values()))
    assert board is not None
    edition, reference = board.edition, cards[FINE_TUNING]
    core, metrics = core_frame(board), metrics_frame(cards.values())
    methods = tables.methods(core, board)
    names = [name for name in core["name"] if name not in NOT_COMPARED and of_edition(name, edition) == name]
    finals = dict(tables.by_group(metrics, names, FINAL))
    groups = tables.fine_tuning(metrics, of_runs(reference))
    learned = [row for row in groups if row.is_learned]
    cloning, packnet = (of_edition(name, edition) for name in ("cloning", "packnet"))
    (axis,) = landscape(submissions, cloning, "cloning").axes  # without it, nothing is stated for good
    gains, correlated = claims.gains(cards, cloning)
    alone = claims.less_than_alone(board, cards)
    without_runs = lacking({row.name: row.look for row in board.rows if row.ranked})
    stated = editions.statements(board, groups, gains, alone)
    effects, templates = results.order_effects(submissions), jinja()
    templates.globals |= {"FINAL": FINAL, "LEARNED": LEARNED, "LOST": LOST, "fine_tuning": FINE_TUNING}
    templates.globals |= {"cloning": cloning, "packnet": packnet, "edition": edition}
    templates.globals |= {"pair_of": partial(tables.against, board)}
    is_first = not any(map(is_trained_here, cards.values()))
    before = editions.stored(FIRST_EDITION, editions.Statement, lambda: stated, is_open=is_first)
    if is_first:
        page = templates.get_template("first-edition.md.jinja").render(
            transfer_titles=[BY_NAME[name].title for name in tables.TRANSFERS],
            transfers=tables.transfers(metrics),
            practice=tables.practice_by_other_runs(results.evaluations(submissions / FINE_TUNING)),
            descending=orders(metrics, effects, "descending"),
            turned=turned(list(cards.values())),
        )
        write_text(FIRST_EDITION.with_suffix(".md"), page + "\n")
    templates.globals |= {"hypotheses": verdicts(cards, bool(without_runs))}

    write_picture(figure(board.rows[:FIRST], board.references), "plane", IMAGES / "overview.svg")
    draw_groups(list(finals.items()), [group.name for group in CORE], FOLDER / "groups.svg")
    scores = tables.scores_by_stage(reference)
    draw_retention(scores, tables.most_forgotten(learned), FOLDER / "retention.svg")
    write_picture(axis.large, "landscape", IMAGES / "landscape.svg")

    policies = results.policies([submissions / name for name in names])
    policies = policies[policies["group"].isin([group.id for group in CORE])]
    trained = set(metrics[metrics["name"] == FINE_TUNING]["group"])
    scored = {row.group.name for row in groups}
    joint, *_ = other_ways = [
        tables.Method(row, {}) for _, row in core[core["name"].isin(IN_OTHER_WAYS)].iterrows()
    ]
    known = {method.row["name"]: method for method in methods}
    block = templates.get_template("readme.md.jinja").render(known=known, joint=joint)
    write_text(README, RESULTS.sub(lambda _: block + "\n", README.read_text("utf-8")))
    text = templates.get_template("page.md.jinja").render(
        budget=STANDARD_BUDGET,
        core=[group.name for group in CORE],
        methods=methods,
        descriptions={name: card.manifest.description for name, card in cards.items() if card.manifest},
        improvements=tables.improvements(methods, cards),
        other_ways=other_ways,
        incomplete=core[~core["ranked"] & core["name"].isin(names)].to_dict("records"),
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
        replay={
            metric: tables.replay({name: of_runs(cards[name], metric) for name in REPLAY})
            for metric in (LEARNED, FINAL, LOST)
        },
        tuning={name: card.manifest.tuning for name, card in cards.items() if card.manifest},
        variants=board.variants,
        kept={
            group: tables.Value.of(retention([log], len(log.runs)))
            for group, logs in reference.groups.items()
            if (log := logs.get("sequential")) and log.metrics[LOST].runs
        },
        outcomes=editions.outcomes(before, stated),
        lacking=without_runs,
        gains=gains,
        correlated=correlated,
        differences=claims.differences(cards, cloning, packnet),
        less_than_alone=alone,
        is_learned_score=claims.is_learned_score(cards),
        selections=claims.selections(board, cards),
        ends=[row.metrics[FINAL].mean for row in board.lists[0].rows if row.ranked],
        positions={
            group.name: ends_by_task(reference.groups[group.id]["sequential"])
            for group in CORE
            if group.id in SUITES["gravity"]
        },
        balanced=orders(metrics, effects, "balanced"),
        bases=bases.base_by_addition(
            {
                name: {group: log.metrics[FINAL].runs for group, log in core_logs(card).items()}
                for name, card in cards.items()
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
        waiting=[
            name for name, card in cards.items() if not card.groups and of_edition(name, edition) == name
        ],
        never=[group.name for group in GROUPS.values() if group.id not in trained],
        no_balanced="balanced" not in set(metrics["protocol"]),
    )
    write_text(PAGE, text + "\n")
