"""What a number opens: its runs, interval and test, the files behind it, and the command that prints it.

A script per submission and board hands it to ``static/numbers.js``, because a page in a file cannot read
HTML. Without that script a number is a link to the results of its submission.
"""

import json
from collections.abc import Iterator

from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.ranking.boards import BoardRow, CoreBoard, CoreRow
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import core_logs
from gym_extensions.site import board_views, paths, submission_results
from gym_extensions.site.pages import core, page
from gym_extensions.site.text import ends, fixed, interval, mean, p_equals, rank
from gym_extensions.submissions.layout import POSES


def publish(site: board_views.Leaderboard, render: page.Render) -> Iterator[page.File]:
    """The scripts of the rows of the boards, then of those of the core, with a badge each."""
    tests: dict[tuple[str, str, str], dict[str, str]] = {}  # by protocol, budget and name, then by group
    for view in site.boards:
        for row in view.rows:
            path = paths.number_file(row.card.name, view.group, view.protocol, view.budget)
            test = tested(row.submission, view)
            tests.setdefault((view.protocol, view.budget, row.card.name), {})[view.group] = test
            metrics = {name: row.result.metric(name) for name in view.columns}
            values = {"board": view, "row": row, "test": test, "values": metrics}
            yield _script("numbers-board.html", path, row.card, render, **values)
    if board := site.scored.core:
        cards, compared = {card.name: card for card in site.submissions}, verdicts(board)
        for each in board.rows:
            on_groups = tests.get((submission_results.SEQUENTIAL, board.budget, each.name), {})
            values = {"row": each, "runs": first_runs(each, cards[each.name]), "tests": on_groups}
            values |= {"verdicts": compared.get(each.name, {})}
            path, card, kept = paths.number_file(each.name), cards[each.name], each.metrics[core.FINAL]
            yield _script("numbers-core.html", path, card, render, **values)
            said = f"kept {mean(kept)} ({ends(kept)}), rank {rank(kept.rank)}" if kept.rank else each.level
            badge = paths.submission_file(each.name, "badge.svg")
            yield badge, render("badge.svg", badge, said=said)


def _script(template: str, path: str, card: Scorecard, render: page.Render, **values: object) -> page.File:
    folder = render.folders.get(card.name)
    watched = {file.stem for file in (folder / POSES).glob("*.json")} if folder else set()
    markup = render(template, path, card=card, watched=watched, **values)
    return path, f"openNumber({json.dumps(path)},{json.dumps(markup)});\n"


def first_runs(row: CoreRow, card: Scorecard) -> dict[str, MetricValue]:
    """The score on each group of the core with the runs that are compared."""
    logs = core_logs(card)
    return {
        name: MetricValue(each.mean, each.low, each.high, logs[name].metrics[core.FINAL].runs[: each.runs])
        for name, each in row.groups.items()
    }


def tested(row: BoardRow, board: board_views.BoardView) -> str:
    """How the score of a row compares with the first of its board, or of the first with the next one."""
    if (other := row.vs_leader or row.vs_next) is None:
        return row.why or "The only one ranked."
    word = "below" if row.vs_leader else "above"
    said = f"significantly {word}" if other.separated else f"not significantly {word}"
    ends = f" ({interval(*other.difference.ends)})" if other.difference.ends else ""
    title = next(each.submission.title for each in board.rows if each.submission.name == other.name)
    return f"{said} {title}: difference {fixed(other.difference.mean)}{ends}"


def verdicts(board: CoreBoard) -> dict[str, dict[str, list[str]]]:
    """By name and verdict on the core score, the other ranked methods, each with its p value."""
    titles = {row.name: row.title for row in board.rows}
    found: dict[str, dict[str, list[str]]] = {}
    for pair in board.pairs[core.FINAL]:
        for name, other in ((pair.first, pair.second), (pair.second, pair.first)):
            said = f"{titles[other]} ({p_equals(pair.p_value)})"
            found.setdefault(name, {}).setdefault(pair.verdict, []).append(said)
    return found
