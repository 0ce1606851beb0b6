"""Pull requests with an entry: each is passed, sent to review or refused by the name of a rule."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from gym_extensions.curation import gate
from gym_extensions.curation.git import Repository
from gym_extensions.verification.limits import Limits

from .checks import checked, rules
from .plays import NEW, PLAYS, index
from .repositories import commit

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")


def test_a_new_entry_passes_with_its_scores_and_labels(request_with_entry: Path) -> None:
    report = checked(request_with_entry, number=17)
    assert (report.kind, report.verdict, report.problems) == ("submission", "passed", ())
    assert (report.entry, report.pull_request) == ("new", 17)
    assert (report.level, report.repeated) == ("claimed", 0)
    assert "sample" in report.notes[0], "nothing is repeated of policies that sample"
    assert [(score.group, score.protocol, score.runs) for score in report.scores] == [
        ("hopper-gravity-v0", "sequential", 2),
        ("hopper-gravity-v0", "single", 2),
    ]
    assert report.labels == ("claimed", "submission")


@pytest.mark.usefixtures("no_judge")
def test_the_files_of_a_pull_request_are_never_checked_out(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands: list[Sequence[str]] = []
    command = Repository._command

    def listed(self: Repository, *words: str) -> list[str]:
        commands.append(words)
        return command(self, *words)

    monkeypatch.setattr(Repository, "_command", listed)
    assert checked(project, head="entry").verdict == "passed"
    assert {words[0] for words in commands} == {"rev-parse", "merge-base", "diff-tree", "ls-tree", "cat-file"}
    assert not (project / NEW).exists()


def test_problems_of_the_submission_are_in_the_report(
    request_with_entry: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commit(request_with_entry, {f"{NEW}/hopper-gravity/agent.pkl": b"pickle"})
    # In this process: the test before starts the limited one.
    monkeypatch.setattr(gate, "answers", lambda job, call, limits: gate.judge(call))
    report = checked(request_with_entry)
    assert (report.verdict, report.level, report.labels) == ("refused", None, ("refused", "submission"))
    assert rules(report) == [("unexpected-name", "hopper-gravity/agent.pkl")]


@pytest.mark.usefixtures("no_judge")
def test_an_edit_of_an_entry_goes_to_its_owner_and_a_maintainer(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "A text.\n"})
    report = checked(project)
    assert (report.kind, report.verdict, report.entry) == ("edit", "review", "old")
    assert report.owners == ("@alice", "@project/maintainers")
    assert report.labels == ("claimed", "edits-entry")


def test_a_change_of_code_alone_is_not_judged(project: Path) -> None:
    commit(project, {"scoring/rank.py": "rank = 2\n", ".github/workflows/gate.yml": "on: push\n"})
    report = checked(project)
    assert (report.kind, report.verdict, report.labels) == ("code", "not-judged", ())


@pytest.mark.parametrize("name", PLAYS)
def test_a_pull_request_with_a_new_entry_and_something_else_is_refused_by_name(
    request_with_entry: Path, name: str
) -> None:
    rule, where, play = PLAYS[name]
    play(request_with_entry)
    report = checked(request_with_entry)
    assert report.verdict == "refused"
    assert (rule, where) in rules(report)
    assert report.scores == ()


@pytest.mark.parametrize(
    ("name", "rule"),
    [("Old", "case-collision"), ("CON", "reserved-name"), ("x" * 65, "entry-name"), ("_new", "entry-name")],
)
def test_a_name_of_an_entry_that_some_system_confuses_is_refused(project: Path, name: str, rule: str) -> None:
    index(project, ("100644", "x", f"submissions/{name}/submission.toml"))
    assert rule in [problem.rule for problem in checked(project).problems]


def test_an_entry_that_is_replaced_by_a_link_is_refused(project: Path) -> None:
    shutil.rmtree(project / "submissions" / "old")
    (project / "submissions" / "old").symlink_to("../scoring")
    commit(project)
    assert ("stray-file", "submissions/old") in rules(checked(project))


def test_a_submission_that_reaches_a_limit_is_refused(request_with_entry: Path) -> None:
    report = checked(request_with_entry, limits=Limits(wall_seconds=0))
    assert [rule for rule, _ in rules(report)] == ["limit-reached"]


def test_an_equal_single_task_log_is_no_copy(request_with_entry: Path) -> None:
    """Methods that differ only between tasks have the same bytes there, by the same seeds."""
    path = "hopper-gravity/single/run0"
    for suffix in ("csv", "npz"):
        old = (request_with_entry / f"submissions/old/{path}.{suffix}").read_bytes()
        (request_with_entry / f"{NEW}/{path}.{suffix}").write_bytes(old)
    commit(request_with_entry)
    assert "copied-run" not in [rule for rule, _ in rules(checked(request_with_entry))]
