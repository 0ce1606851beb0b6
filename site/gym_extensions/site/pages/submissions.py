"""The pages of a submission with its citation, metrics and commands, and the list of all submissions."""

import re
import shlex
import unicodedata
from collections import Counter
from collections.abc import Iterator

from gym_extensions.scoring.output.board_frames import metrics_frame, to_csv
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import board_views, paths, submission_results
from gym_extensions.site.pages import core
from gym_extensions.site.pages.landscapes import View
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.play.watch import watches
from gym_extensions.site.text import ends, mean, split_version
from gym_extensions.submissions.layout import TRAINED
from gym_extensions.submissions.poses import load_submission
from gym_extensions.submissions.review import TRAINED_HERE


def publish_submission(submission: Scorecard, render: Render) -> Iterator[File]:
    """The page of a submission, those of its groups if there are several, and the files that they offer."""
    path = paths.submission_path(submission.name)
    folder = render.folders.get(submission.name)
    panels = watches(submission, load_submission(folder) if folder else {})
    landscapes = render.landscapes.views(submission)
    networks = {
        group: each
        for group, each in render.networks.get(submission.name, {}).items()
        if group in submission.groups
    }
    shown = {"submission": submission, "watches": panels, "landscapes": landscapes, "networks": networks}
    yield path, render("submission.html", path, bibtex=bibtex, commands=commands, **shown)
    for group in submission_results.separate_groups(submission):
        page = paths.results_path(submission.name, group)
        yield page, render("results.html", page, group=group, **shown)
    for group, view in landscapes.items():
        if isinstance(view, View):
            yield paths.submission_file(submission.name, f"landscape-{group}.json"), view.landscape.to_json()
    for panel in panels.values():
        yield panel.path, panel.script
    if not submission.problems:
        frame = metrics_frame([submission])
        yield paths.submission_file(submission.name, "metrics.csv"), to_csv(frame)
        yield paths.submission_file(submission.name, "citation.bib"), bibtex(submission, render.source)


def publish_list(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """All submissions by level and name, published tables and refused ones last."""
    on_boards = {row.submission.name for board in site.boards for row in board.rows}
    rows = site.scored.core.rows if site.scored.core else ()
    scores = {row.name: row.metrics[core.FINAL] for row in rows}
    levels = ["", *submission_results.LEVELS]
    submissions = sorted(site.submissions, key=lambda submission: -levels.index(submission.level or ""))
    found = Counter(submission.level or "refused" for submission in submissions)
    values = {"submissions": submissions, "levels": found, "on_boards": on_boards, "scores": scores}
    yield "submissions.html", render("submissions.html", "submissions.html", **values)


ESCAPED = {character: f"\\{character}" for character in "&%$#_"} | {
    "\\": r"\textbackslash{}",
    "{": r"\textbraceleft{}",
    "}": r"\textbraceright{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
}
URL = re.compile(r"[^\s{}\\%]+")


def bibtex(card: Scorecard, source: paths.Source) -> str:
    """A submission of type ``misc`` with title, authors, code, date and core score. Its text is escaped."""
    facts = card.manifest
    fields = {"title": f"{{{_escaped(card.title)}}}"}
    if facts is not None and facts.authors:
        fields["author"] = " and ".join(f"{{{_escaped(author)}}}" for author in facts.authors)
    if dated := submission_results.dated(card):
        fields["year"] = dated.split()[-1].partition("-")[0]
    fields["howpublished"] = "Submission of the gym-extensions leaderboard"
    if source.url or source.repository:
        page = f"{source.url}/{paths.submission_path(card.name)}" if source.url else source.repository
        fields["howpublished"] += f", \\url{{{_escaped(page)}}}"
    if source.version:
        fields["version"] = f"gym-extensions {_escaped(source.version)}"
    fields["note"] = f"Submission {_escaped(card.name)}"
    if facts is not None and URL.fullmatch(facts.code.url):
        fields["url"] = facts.code.url
    if facts is not None and facts.code.commit:
        fields["note"] += f", code at commit {_escaped(facts.code.commit)}"
    if dated:
        fields["note"] += f", {dated}"
    if card.core and (score := card.core.metrics[core.FINAL]).mean is not None:
        fields["note"] += f", core score {mean(score)} ({ends(score)})"
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items()]
    return "\n".join([f"@misc{{gym-extensions-{paths.slug(card.name)},", *lines, "}", ""])


def _escaped(text: str) -> str:
    """Text on one line, with the characters that BibTeX and TeX read as commands escaped.

    BibTeX counts braces after a backslash, too, so a brace is a command with balanced ones.
    """
    line = " ".join(unicodedata.normalize("NFC", text).split())
    return "".join(ESCAPED.get(character, character) for character in line)


def commands(card: Scorecard) -> str:
    """The commands that check a submission, print its scores, repeat a run and load a policy, in a clone."""
    folder, lines = f"submissions/{card.name}", []
    if submission_results.has_policies(card):
        lines = [
            "# repeat the logged episodes with the published policies, and run these on new seeds",
            f"gym-extensions verify {shlex.quote(folder)}",
        ]
    results = [result for result in submission_results.on_groups(card) if result.detail.provenance]
    for result in results[:1]:
        made = result.detail.provenance[0]
        where = f", in {folder}/agent" if result.detail.level == TRAINED_HERE else ""
        comment = f"# what trained run {made.run} on {result.group}{where}"
        lines += [comment, made.command] if made.command else []
    sequential = next(
        (result for result in results if result.protocol == submission_results.SEQUENTIAL), None
    )
    if sequential and sequential.detail.provenance[0].policies:
        group = split_version(sequential.group)[0]
        trained = card.training if sequential.detail.level == TRAINED_HERE else None
        runs = f"{folder}/{TRAINED}/{trained.attempts}" if trained else folder
        lines += [
            "# a policy, in Python: of a run, after any stage",
            "from gym_extensions import policies",
            f"policy = policies.load({runs!r}, {group!r}, run={sequential.runs[0]}, "
            f"stage={len(sequential.tasks)})",
        ]
    lines += [
        "# its scores, the core score first; and in Python as a data frame",
        f"gym-extensions score {shlex.quote(folder)}",
        "from gym_extensions import results",
        f"metrics = results.metrics({folder!r})",
    ]
    return "\n".join(lines)
