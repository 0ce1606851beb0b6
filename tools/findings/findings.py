"""Writes docs/findings.md and its figures from the committed submissions: ``make findings``.

Every number and verdict is computed. The text is in ``page.md.jinja``; ``tables.py`` says what is compared.
"""

import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

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


class Evidence:
    """The committed submissions, and what several pages and figures take from them."""

    def __init__(self, submissions: Path) -> None:
        self.submissions = submissions
        cards = valid_scorecards(submissions, make_scorer())
        self.cards = {folder.name: card for folder, card in cards.items()}
        self.reference = self.cards[FINE_TUNING]
        board = core_board(list(self.cards.values()))
        assert board is not None
        self.board, self.edition = board, board.edition
        self.cloning, self.packnet = (of_edition(name, board.edition) for name in ("cloning", "packnet"))
        self.core, self.metrics = core_frame(board), metrics_frame(self.cards.values())
        self.effects = results.order_effects(submissions)
        self.methods = tables.methods(self.core, board)
        in_other_ways = self.core[self.core["name"].isin(IN_OTHER_WAYS)]
        self.other_ways = [tables.Method(row, {}) for _, row in in_other_ways.iterrows()]
        self.names = [
            name
            for name in self.core["name"]
            if name not in NOT_COMPARED and of_edition(name, board.edition) == name
        ]
        self.finals = dict(tables.by_group(self.metrics, self.names, FINAL))
        self.forgetting = tables.fine_tuning(self.metrics, runs_by_group(self.reference, LOST))
        self.learned = [row for row in self.forgetting if row.is_learned]
        self.gains, self.correlated = claims.gains(self.cards, self.cloning)
        self.less_than_alone = claims.less_than_alone(board, self.cards)
        self.lacking = lacking({row.name: row.look for row in board.rows if row.ranked})


def runs_by_group(card: Scorecard, metric: str) -> dict[str, Sequence[float]]:
    """A metric of every sequential run of a submission, by group id."""
    logs = {group: card.log(group, "sequential") for group in card.groups}
    return {group: log.metrics[metric].runs for group, log in logs.items() if log and metric in log.metrics}


def jinja() -> Environment:
    """The templates of the pages, which refuse a name that nothing defines."""
    here = FileSystemLoader(Path(__file__).parent)
    made = Environment(loader=here, undefined=StrictUndefined, trim_blocks=True)
    made.globals |= {"FINAL": FINAL, "LEARNED": LEARNED, "LOST": LOST, "fine_tuning": FINE_TUNING}
    made.globals |= {"fmt": partial(fixed, digits=2), "rank": rank, "Value": tables.Value}
    made.globals |= {"percent": tables.percent, "sides": tables.sides, "WORDS": tables.WORDS, "zip": zip}
    return made


def landscape(submissions: Path, *names: str) -> View:
    """The landscape on hopper-gravity of the first of these submissions that has one.

    Raises ``BenchError`` if none has.
    """
    group = GROUPS["hopper-gravity"]
    found = {folder.name: landscapes_of(folder) for folder in submissions.iterdir() if folder.is_dir()}
    for name in names:
        if shown := found.get(name, {}).get(group.id):
            return View(group, shown, best(found))
    hint = f"Run: gym-extensions maintain landscapes submissions/{names[0]} --groups {group.name}"
    raise BenchError("no-landscape", f"{names[0]} has no landscape.", str(submissions), hint)


def verdicts(cards: Mapping[str, Scorecard], is_early: bool) -> list[hypotheses.Verdict]:
    """The verdicts on the hypotheses: given once, with what is committed, and as stored from then on."""

    def give() -> list[hypotheses.Verdict]:
        return hypotheses.tested(cards, Repository(ROOT).fixed(ROOT, ["submissions", "scoring", "tools"]))

    is_open = not (is_early or HYPOTHESES.exists())
    return editions.stored(HYPOTHESES, hypotheses.Verdict, give, is_open=is_open)


def first_edition_facts(evidence: Evidence) -> dict[str, Any]:
    """What the page of the first edition shows, by its names in the template."""
    return {
        "transfer_titles": [BY_NAME[name].title for name in tables.TRANSFERS],
        "transfers": tables.transfers(evidence.metrics),
        "practice": tables.practice_by_other_runs(results.evaluations(evidence.submissions / FINE_TUNING)),
        "descending": orders(evidence.metrics, evidence.effects, "descending"),
        "turned": turned(list(evidence.cards.values())),
    }


def core_facts(evidence: Evidence) -> dict[str, Any]:
    """What the page shows of the core, by its names in the template."""
    cards, board, core = evidence.cards, evidence.board, evidence.core
    manifests = {name: card.manifest for name, card in cards.items() if card.manifest}
    on_core = {name: core_logs(card).items() for name, card in cards.items()}
    finals = {name: {group: log.metrics[FINAL].runs for group, log in logs} for name, logs in on_core.items()}
    return {
        "budget": STANDARD_BUDGET,
        "core": [group.name for group in CORE],
        "methods": evidence.methods,
        "descriptions": {name: manifest.description for name, manifest in manifests.items()},
        "tuning": {name: manifest.tuning for name, manifest in manifests.items()},
        "improvements": tables.improvements(evidence.methods, cards),
        "other_ways": evidence.other_ways,
        "failed": {name: card.training.failed for name, card in cards.items() if card.training},
        "incomplete": core[~core["ranked"] & core["name"].isin(evidence.names)].to_dict("records"),
        "variants": board.variants,
        "lacking": evidence.lacking,
        "gains": evidence.gains,
        "correlated": evidence.correlated,
        "differences": claims.differences(cards, evidence.cloning, evidence.packnet),
        "less_than_alone": evidence.less_than_alone,
        "is_learned_score": claims.is_learned_score(cards),
        "selections": claims.selections(board, cards),
        "ends": [row.metrics[FINAL].mean for row in board.lists[0].rows if row.ranked],
        "positions": {
            group.name: ends_by_task(evidence.reference.groups[group.id]["sequential"])
            for group in CORE
            if group.id in SUITES["gravity"]
        },
        "balanced": orders(evidence.metrics, evidence.effects, "balanced"),
        "bases": bases.base_by_addition(finals),
        "BASES": bases.BASES,
        "BASE_GROUPS": [name.rpartition("-v")[0] for name in bases.GROUPS],
        "finals": evidence.finals.items(),
        "losses": tables.by_group(evidence.metrics, evidence.names, LOST),
    }


def other_facts(evidence: Evidence) -> dict[str, Any]:
    """What the page shows of other groups, of networks, and of what is missing."""
    cards, metrics, names = evidence.cards, evidence.metrics, evidence.names
    replayed = {name: cards[name] for name in REPLAY}
    trained = set(metrics[metrics["name"] == FINE_TUNING]["group"])
    scored = {row.group.name for row in evidence.forgetting}
    folders = [evidence.submissions / name for name in names]
    policies = results.policies(folders)
    policies = policies[policies["group"].isin([group.id for group in CORE])]
    return {
        "replay": {
            metric: tables.replay({name: runs_by_group(card, metric) for name, card in replayed.items()})
            for metric in (LEARNED, FINAL, LOST)
        },
        "learned": evidence.learned,
        "unlearned": [row for row in evidence.forgetting if not row.is_learned],
        "kept": {
            group: tables.Value.of(retention([log], len(log.runs)))
            for group in evidence.reference.groups
            if (log := evidence.reference.log(group, "sequential")) and log.metrics[LOST].runs
        },
        "without_score": [g.name for g in GROUPS.values() if g.id in trained and g.name not in scored],
        "open_tasks": {name: each for name, each in tables.open_tasks().items() if name in scored},
        "suites": [
            (name, [tables.value(metrics, FINE_TUNING, name, metric) for metric in COLUMNS])
            for name in SUITES
            if name in trained
        ],
        "landscapes": tables.between_and_beyond(results.landscapes(folders)),
        "predictors": tables.predictors(policies),
        "networks": tables.network_changes(policies),
        "missing": {
            group.name: [name for name, values in evidence.finals.items() if not values[place].is_known]
            for place, group in enumerate(CORE)
        },
        "waiting": [
            name
            for name, card in cards.items()
            if not card.groups and of_edition(name, evidence.edition) == name
        ],
        "never": [group.name for group in GROUPS.values() if group.id not in trained],
        "no_balanced": "balanced" not in set(metrics["protocol"]),
    }


def main() -> None:
    """Writes the page and its figures, the results of the README, and what an edition states for good."""
    evidence = Evidence(ROOT / "submissions")
    cards, board = evidence.cards, evidence.board
    # Without a landscape, nothing is stated for good.
    (axis,) = landscape(evidence.submissions, evidence.cloning, "cloning").axes
    stated = editions.statements(board, evidence.forgetting, evidence.gains, evidence.less_than_alone)
    is_first = not any(map(is_trained_here, cards.values()))
    before = editions.stored(FIRST_EDITION, editions.Statement, lambda: stated, is_open=is_first)
    templates = jinja()
    templates.globals |= {
        "edition": evidence.edition,
        "cloning": evidence.cloning,
        "packnet": evidence.packnet,
        "pair_of": partial(tables.against, board),
        "hypotheses": verdicts(cards, is_early=bool(evidence.lacking)),
    }
    facts = core_facts(evidence) | other_facts(evidence)
    text = templates.get_template("page.md.jinja").render(facts, outcomes=editions.outcomes(before, stated))
    known = {method.row["name"]: method for method in evidence.methods}
    readme = templates.get_template("readme.md.jinja").render(known=known, other_ways=evidence.other_ways)

    if is_first:
        page = templates.get_template("first-edition.md.jinja").render(first_edition_facts(evidence))
        write_text(FIRST_EDITION.with_suffix(".md"), page + "\n")

    write_picture(figure(board.rows[:FIRST], board.references), "plane", IMAGES / "overview.svg")
    write_picture(axis.large, "landscape", IMAGES / "landscape.svg")
    draw_groups(list(evidence.finals.items()), [group.name for group in CORE], FOLDER / "groups.svg")
    scores = tables.scores_by_stage(evidence.reference)
    draw_retention(scores, tables.most_forgotten(evidence.learned), FOLDER / "retention.svg")
    write_text(README, RESULTS.sub(lambda _: readme + "\n", README.read_text("utf-8")))
    write_text(PAGE, text + "\n")
