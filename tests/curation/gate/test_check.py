"""Pull requests that are played with git: each is passed, sent to review or refused by the name of a rule."""

from __future__ import annotations

import hashlib
import json
import shutil
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from gym_extensions.curation import git as plumbing
from gym_extensions.curation.digest import folder_digest, folder_hashes
from gym_extensions.curation.evidence import prove
from gym_extensions.curation.gate import check
from gym_extensions.curation.gate.check import Request, check_pull_request
from gym_extensions.curation.gate.cli import main
from gym_extensions.curation.gate.judgement import Judgement, judgement_of
from gym_extensions.curation.gate.limits import Limits
from gym_extensions.curation.gate.report import GateReport, read_report
from gym_extensions.curation.gate.rules import RULES
from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.append import Author, append, repeated
from gym_extensions.curation.ledger.chain import read
from gym_extensions.curation.ledger.verify import check_folders
from gym_extensions.curation.salt import derive_salt
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces
from gym_extensions.scoring.documents import json_schema

from ..repositories import commit, git, make_crossed, make_project
from .plays import NEW, PLAYS, index

VALUE = "e" * 40

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with code, an owner, an entry and its ledger; the branch ``entry`` adds a new entry."""
    return make_project(tmp_path_factory.mktemp("base") / "project")


@pytest.fixture
def project(base: Path, tmp_path: Path) -> Path:
    """A copy of the project on a branch that equals its base."""
    return Path(shutil.copytree(base, tmp_path / "project"))


@pytest.fixture
def request_with_entry(project: Path) -> Path:
    """A copy of the project on a branch that adds a new entry."""
    git(project, "switch", "--quiet", "entry")
    return project


@pytest.fixture
def no_judge(monkeypatch: pytest.MonkeyPatch) -> None:
    """Judges no submission: for what is decided before or after that."""
    judgement = Judgement(level="replayed", replayed=3, episodes=200, notes=("`@alice` <img>",))
    monkeypatch.setattr(check, "judge", lambda *_: judgement)


def checked(project: Path, **changes: object) -> GateReport:
    request = Request(Repository(project), "main")
    return check_pull_request(replace(request, **changes))  # type: ignore[arg-type]


def rules(report: GateReport) -> list[tuple[str, str]]:
    return [(problem.rule, problem.where) for problem in report.problems]


def test_a_new_entry_passes_with_its_digest_salt_scores_and_labels(request_with_entry: Path) -> None:
    report = checked(request_with_entry, value=VALUE, number=17)
    assert (report.kind, report.verdict, report.problems) == ("submission", "passed", ())
    assert (report.entry, report.pull_request) == ("new", 17)
    assert report.digest == folder_digest(request_with_entry / NEW)
    assert report.salt == derive_salt(digest_without_traces(folder_hashes(request_with_entry / NEW)), VALUE)
    assert (report.level, report.replayed, report.episodes) == ("validated", 0, 200)
    assert [(score.group, score.protocol, score.runs) for score in report.scores] == [
        ("hopper-gravity-v0", "single", 2)
    ]
    assert report.labels == ("submission", "validated")


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
    monkeypatch.setattr(check, "judge", lambda folder, salt, _: judgement_of(prove(folder, salt)))
    report = checked(request_with_entry)
    assert (report.verdict, report.level, report.labels) == ("refused", None, ("refused", "submission"))
    assert rules(report) == [("unexpected-name", "hopper-gravity/agent.pkl")]


@pytest.mark.usefixtures("no_judge")
def test_an_edit_of_an_entry_goes_to_its_owner_and_a_maintainer(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "A text.\n"})
    report = checked(project)
    assert (report.kind, report.verdict, report.entry) == ("edit", "review", "old")
    assert report.owners == ("@alice", "@project/maintainers")
    assert report.labels == ("edits-entry", "replayed")


@pytest.mark.usefixtures("no_judge")
def test_the_merge_commit_of_an_entry_gives_the_salt_of_the_pull_request_with_its_traces(
    project: Path,
) -> None:
    merged = git(project, "rev-parse", "main")
    path = "submissions/old/hopper-gravity/traces/salt.txt"
    commit(project, {path: "x"})
    report = checked(project)
    assert report.value == merged
    files = folder_hashes(project / "submissions" / "old")
    assert report.salt == derive_salt(digest_without_traces(files), merged)
    git(project, "switch", "--quiet", "-c", "later")
    git(project, "branch", "--force", "main", "request")
    moved = project / path
    moved.rename(moved.with_name("other.npz"))
    commit(project)
    assert (checked(project).problems, checked(project).value) == ((), merged)
    commit(project, {"submissions/old/README.md": "A text.\n"})
    assert (checked(project).value, checked(project, head="entry").value) == ("", "")


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
    assert (report.digest, report.scores) == ("", ())


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


def test_a_pull_request_without_a_change_or_a_common_ancestor_is_refused(project: Path) -> None:
    ((rule, where),) = rules(checked(project))
    assert (rule, len(where)) == ("no-change", 40), "the commit"
    git(project, "switch", "--quiet", "--orphan", "alone")
    commit(project, {"submissions/new/submission.toml": "x"})
    assert rules(checked(project)) == [("unrelated-history", "")]


def test_a_history_with_several_common_ancestors_is_refused(project: Path) -> None:
    """The merge would revert what the base changed on its side."""
    make_crossed(project)
    (problem,) = checked(project).problems
    assert (problem.rule, problem.message) == ("crossed-history", "The two commits have 2 common ancestors.")


@pytest.mark.usefixtures("no_judge")
def test_another_salt_of_the_same_logs_is_noted(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "A typo.\n"})
    assert checked(project).notes[0] == "The logs stay, and their salt becomes another one."
    git(project, "switch", "--quiet", "main")
    git(project, "merge", "--quiet", "--no-ff", "--no-edit", "request")
    git(project, "switch", "--quiet", "-c", "traces")
    commit(project, {"submissions/old/hopper-gravity/traces/x.npz": "x"})
    assert checked(project, head="traces").notes[0] == (
        "This is salt 2 of the same logs: other files were changed after the first."
    )


def test_a_line_about_an_entry_without_files_is_refused(project: Path) -> None:
    line = read(project / "submissions")[-1]
    nothing = hashlib.sha256(b"").hexdigest()
    append(project / "submissions", [replace(line, entry="absent", digest=nothing)])
    commit(project)
    assert rules(checked(project)) == [("ledger-entry", "absent")]
    assert [(problem.rule, problem.message) for problem in check_folders(project / "submissions")] == [
        ("ledger-entry", "The folder is absent.")
    ]


def test_an_edit_of_an_entry_that_the_base_changed_meanwhile_is_refused(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "One text.\n"})
    git(project, "switch", "--quiet", "main")
    commit(project, {"submissions/old/README.md": "Another text.\n"})
    assert rules(checked(project, head="request")) == [("outdated-entry", "submissions/old")]


@pytest.mark.usefixtures("no_judge")
def test_a_new_entry_is_compared_with_the_base_where_it_started(project: Path) -> None:
    git(project, "switch", "--quiet", "main")
    commit(project, {"scoring/rank.py": "rank = 3\n"})
    assert checked(project, head="entry").verdict == "passed"


def test_appended_lines_of_the_ledger_go_to_a_maintainer(project: Path) -> None:
    line = read(project / "submissions")[-1]
    append(project / "submissions", [repeated(line, "challenged", Author("2026-01-02", "In doubt."))])
    commit(project)
    report = checked(project)
    assert (report.kind, report.verdict, report.labels) == ("ledger", "review", ("ledger",))


def test_an_edited_line_of_the_ledger_is_refused_even_with_a_whole_chain(project: Path) -> None:
    line = read(project / "submissions")[-1]
    (project / "submissions" / "ledger.jsonl").unlink()
    append(project / "submissions", [replace(line, reason="Another reason.")])
    commit(project)
    assert rules(checked(project)) == [("ledger-edited", "submissions/ledger.jsonl")]


def test_a_line_that_breaks_the_chain_is_refused(project: Path) -> None:
    path = project / "submissions" / "ledger.jsonl"
    line = repeated(read(project / "submissions")[-1], "challenged", Author("2026-01-02", "In doubt."))
    commit(project, {"submissions/ledger.jsonl": path.read_bytes() + line.encode()})
    assert rules(checked(project)) == [("ledger-chain", "submissions/ledger.jsonl, row 2")]


def test_a_line_about_other_files_is_refused(project: Path) -> None:
    line = replace(read(project / "submissions")[-1], entry="absent", date="2026-01-02")
    append(project / "submissions", [line])
    commit(project)
    assert rules(checked(project)) == [("ledger-entry", "absent")]


@pytest.mark.parametrize(
    ("path", "text", "expected"),
    [
        ("challenges/old/a.txt", "In doubt.\n", []),
        ("challenges/new/a.txt", "In doubt.\n", [("unknown-entry", "challenges/new/a.txt")]),
        ("challenges/old/a.html", "<b>\n", [("challenge-name", "challenges/old/a.html")]),
        ("challenges/old/a.txt", "\x1b[2J\n", [("challenge-text", "challenges/old/a.txt")]),
    ],
)
def test_a_challenge_goes_to_a_maintainer_if_it_is_plain_text_about_an_entry(
    project: Path, path: str, text: str, expected: list[tuple[str, str]]
) -> None:
    commit(project, {path: text})
    report = checked(project)
    assert (report.kind, rules(report)) == ("challenge", expected)
    assert report.verdict == ("refused" if expected else "review")


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits the memory of git")
def test_a_commit_that_stands_for_billions_of_files_is_refused(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blob = git(project, "hash-object", "-w", "--stdin", data=b"x")
    rows = [f"100644 blob {blob}\tfile{number}" for number in range(10)]
    for _ in range(9):
        tree = git(project, "mktree", data="\n".join(rows).encode())
        rows = [f"040000 tree {tree}\tfolder{number}" for number in range(10)]
    root = git(project, "mktree", data=f"040000 tree {tree}\tsubmissions".encode())
    head = git(project, "commit-tree", "-p", "main", "-m", "bomb", root)
    monkeypatch.setattr(plumbing, "MAX_MEMORY", 64 * 2**20)
    assert [problem.rule for problem in checked(project, head=head).problems] == ["git-limit"]


def test_a_submission_that_reaches_a_limit_is_refused(request_with_entry: Path) -> None:
    report = checked(request_with_entry, limits=Limits(wall_seconds=0))
    assert rules(report) == [("limit-reached", "new")]


@pytest.mark.usefixtures("no_judge")
def test_the_command_prints_a_report_that_its_schema_allows_and_reads_it_back(
    project: Path, tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    commit(project, {"submissions/old/README.md": "A text.\n"})
    assert main(["--repository", str(project), "--base", "main", "--json", "--number", "3"]) == 0
    printed = capfdbinary.readouterr().out
    Draft202012Validator(json_schema(GateReport)).validate(json.loads(printed))
    report = read_report(printed)
    assert (report.pull_request, report.kind, report.verdict) == (3, "edit", "review")
    path = project / "report.json"
    path.write_bytes(printed)
    assert main(["--labels", str(path)]) == 0
    assert capfdbinary.readouterr().out == b"edits-entry\nreplayed\n"
    without = tmp_path / "without.json"
    without.write_text(replace(report, kind="code", verdict="not-judged", labels=()).to_json())
    assert main(["--labels", str(without)]) == 0
    assert capfdbinary.readouterr().out == b""
    assert main(["--comment", str(path)]) == 0
    assert b"\n`@alice` <img>\n```" in capfdbinary.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--base", "absent"], "There is no commit 'absent'."),
        (["--head=--all"], "There is no commit '--all'."),
        (["--value", "xyz"], "--value: The value 'xyz' is malformed."),
        (["--repository", "/"], "It is not a git work tree."),
        (["--comment", "absent.json"], "absent.json: No such file or directory."),
    ],
)
def test_wrong_arguments_are_named(
    project: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main(["--repository", str(project), *options]) == 2
    assert message in capsys.readouterr().err


def test_every_rule_has_a_text(capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    assert main(["--rules"]) == 0
    lines = capfdbinary.readouterr().out.decode().splitlines()
    assert [line.split(": ")[0] for line in lines] == list(RULES)
    page = (Path(__file__).parents[3] / "docs" / "pull-requests.md").read_text("utf-8")
    assert [line for line in lines if "| `{}` | {} |".format(*line.split(": ", 1)) not in page] == []
