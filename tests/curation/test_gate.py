"""Pull requests with a submission: each is passed, sent to review or refused by the name of a rule."""

import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import msgspec
import pytest

from gym_extensions.curation import gate
from gym_extensions.curation.gate_report import comment
from gym_extensions.submissions.run import read_run, write_run
from gym_extensions.verification import git as plumbing
from gym_extensions.verification.git import Repository
from gym_extensions.verification.limits import Limits

from ..conftest import refused
from .plays import NEW, PLAYS, index
from .repositories import BOARD_MANIFEST, checked, commit, git, rules

OLD = "submissions/old"
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")


def test_a_new_submission_passes_with_its_scores_and_labels(request_with_submission: Path) -> None:
    report = checked(request_with_submission, number=17)
    assert (report.kind, report.verdict, report.problems) == ("submission", "passed", ())
    assert (report.submission, report.pull_request) == ("new", 17)
    assert (report.level, report.repeated) == ("claimed", 0)
    assert "sample" in report.notes[0], "nothing is repeated of policies that sample"
    assert report.without_policies == 0
    assert {score.group for score in report.scores} == {"hopper-gravity-v0"}
    assert [(score.protocol, score.runs) for score in report.scores] == [("sequential", 2), ("single", 2)]
    assert report.labels == ["claimed", "submission"]


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
    assert checked(project, head="submission").verdict == "passed"
    assert {words[0] for words in commands} == {
        *("rev-parse", "rev-list", "merge-base", "diff-tree", "ls-tree", "cat-file")
    }
    assert not (project / NEW).exists()


def test_the_process_that_reads_the_files_says_nothing_of_the_pull_request(
    request_with_submission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    false = {
        "pull_request": 9,
        "head": "f" * 40,
        "kind": "donation",
        "submission": "old",
        "verdict": "review",
    }
    monkeypatch.setattr(gate, "answers", lambda _, call, __: iter([call["report"] | false]))
    report, head = checked(request_with_submission), git(request_with_submission, "rev-parse", "HEAD")
    assert (report.pull_request, report.head) == (None, head)
    assert (report.kind, report.submission, report.verdict) == ("submission", "new", "passed")


@pytest.mark.usefixtures("in_this_process")
def test_problems_of_the_submission_are_in_the_report(request_with_submission: Path) -> None:
    commit(request_with_submission, {f"{NEW}/hopper-gravity/agent.pkl": b"pickle"})
    report = checked(request_with_submission)
    assert (report.verdict, report.level, report.labels) == ("refused", None, ["refused", "submission"])
    assert rules(report) == [("unexpected-name", "hopper-gravity/agent.pkl")]


@pytest.mark.usefixtures("no_judge")
def test_an_edit_of_a_submission_goes_to_its_owner_and_a_maintainer(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "A text.\n"})
    report = checked(project)
    assert (report.kind, report.verdict, report.submission) == ("edit", "review", "old")
    assert report.labels == ["claimed", "edits-submission"]


@pytest.mark.usefixtures("no_judge")
@pytest.mark.parametrize(("title", "expected"), [("++", []), ("！！", ["same-title"])])
def test_titles_of_symbols_are_compared_as_they_are(project: Path, title: str, expected: list[str]) -> None:
    path = "submissions/{}/submission.toml"
    git(project, "switch", "--quiet", "main")
    commit(project, {path.format("old"): BOARD_MANIFEST.replace("A submission", "!!")})
    git(project, "switch", "--quiet", "submission")
    commit(project, {path.format("new"): BOARD_MANIFEST.replace("A submission", title)})
    assert [rule for rule, _ in rules(checked(project))] == expected


@pytest.mark.usefixtures("no_judge")
def test_the_keys_that_an_edit_changes_are_named(project: Path) -> None:
    manifest = (project / "submissions/old/submission.toml").read_text()
    edited = manifest.replace("steps = 0\n", "steps = 9\n").replace("Submission old", "Another title")
    files: dict[str, str | bytes | None] = {"submissions/old/submission.toml": edited}
    for path in sorted(project.glob("submissions/old/*/sequential/run*.json")):
        document = read_run(path)
        write_run(path, msgspec.structs.replace(document, steps=document.steps - 1, command="mine"))
    commit(project, files)
    report = checked(project)
    assert report.verdict == "review"
    again = "What was verified of it is claimed again."
    assert report.notes[:2] == (
        f"Changed in hopper-gravity/sequential/run0.json and 1 other document: command, steps. {again}",
        f"Changed in submission.toml: title, tuning.steps. {again}",
    )
    assert again in comment(report)
    git(project, "reset", "--quiet", "--hard", "HEAD~")
    path = project / "submissions/old/hopper-gravity/sequential/run0.json"
    document = read_run(path)
    assert document.policies is not None
    policies = msgspec.structs.replace(document.policies, url="https://example.org/run0.npz")
    write_run(path, msgspec.structs.replace(document, policies=policies))
    other = path.with_name("run1.json")
    files = {str(other.relative_to(project)): other.read_text().replace('": ', '":')}
    commit(project, files)
    assert checked(project).notes[:2] == (
        "Changed in hopper-gravity/sequential/run0.json: policies.url.",
        "Changed in hopper-gravity/sequential/run1.json: the spelling.",
    )
    commit(project, {"submissions/old/hopper-gravity/sequential/run0.json": "[]"})
    assert ": arithmetic, " in checked(project).notes[0], "a broken document has no values"


AGENT = f"{OLD}/agent"
EARLY = [("next-version", AGENT)]
FILES = (f"{AGENT}/agent.py", f"{AGENT}/part.py")


@pytest.mark.usefixtures("no_judge")
@pytest.mark.parametrize(
    "case",
    [
        (29, "agent.py:make", {f"{AGENT}/agent.py": "make = other = 2\n"}, EARLY),
        (31, "agent.py:make", {f"{AGENT}/agent.py": "make = other = 2\n", f"{AGENT}/part.py": None}, []),
        (31, "agent.py:make", dict.fromkeys(FILES), [("deleted-file", path) for path in FILES]),
        (1, "agent.py:other", {}, EARLY),
        (31, "agent.py:other", {}, []),
        (29, "agent.py:make", {f"{OLD}/README.md": "A text.\n"}, []),
    ],
)
def test_a_new_version_of_code_waits_thirty_days_and_may_drop_its_files(
    project: Path, monkeypatch: pytest.MonkeyPatch, case: tuple[int, str, dict[str, str | None], object]
) -> None:
    days, entry, files, expected = case
    manifest = (project / OLD / "submission.toml").read_text() + '\n[agent]\nentry = "agent.py:make"\n'
    git(project, "switch", "--quiet", "main")
    monkeypatch.setenv("GIT_COMMITTER_DATE", f"{int(time.time()) - days * 86400} +0000")
    code = dict.fromkeys(FILES, "make = other = 1\n")
    commit(project, code | {f"{OLD}/submission.toml": manifest})
    monkeypatch.delenv("GIT_COMMITTER_DATE")
    manifest = manifest.replace("Submission old", "The old submission")  # no version
    commit(project, {f"{OLD}/submission.toml": manifest})
    git(project, "switch", "--quiet", "-c", "version", "main")
    manifest = manifest.replace("agent.py:make", entry)
    commit(project, {**files, f"{OLD}/submission.toml": manifest})
    report = checked(project)
    assert rules(report) == expected
    assert days != 1 or " 1 day " in report.problems[0].message


def test_the_code_of_a_submission_is_read_and_not_run(request_with_submission: Path) -> None:
    with (request_with_submission / NEW / "submission.toml").open("a", encoding="utf-8") as file:
        file.write('\n[agent]\nentry = "__init__.py:make"\n')
    commit(
        request_with_submission,
        {f"{NEW}/agent/{name}.py": "make = 1 / 0\n" for name in ("__init__", "_part")},
    )
    report = checked(request_with_submission)
    assert (report.verdict, report.trains, report.problems) == ("passed", True, ())
    assert "the code is trained on the core in a box" in comment(report)
    git(request_with_submission, "switch", "--quiet", "main")
    git(request_with_submission, "merge", "--quiet", "submission")
    git(request_with_submission, "switch", "--quiet", "-c", "edit")
    commit(request_with_submission, {f"{NEW}/README.md": "A text.\n"})
    report = checked(request_with_submission)
    assert (report.kind, report.trains, report.problems) == ("edit", False, ()), "the code is as it was"


def test_a_change_of_code_alone_is_not_judged(project: Path) -> None:
    commit(project, {"scoring/rank.py": "rank = 2\n", ".github/workflows/gate.yml": "on: push\n"})
    report = checked(project)
    assert (report.kind, report.verdict, report.labels) == ("code", "not-judged", [])


@pytest.mark.parametrize("name", PLAYS)
def test_a_pull_request_with_a_new_submission_and_something_else_is_refused_by_name(
    request_with_submission: Path, name: str
) -> None:
    rule, where, play = PLAYS[name]
    play(request_with_submission)
    report = checked(request_with_submission)
    assert report.verdict == "refused"
    assert (rule, where) in rules(report)
    assert report.scores == ()


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        *(("Old", "case-collision"), ("CON", "path-characters")),
        *(("x" * 65, "submission-name"), ("_new", "submission-name")),
    ],
)
def test_a_name_that_some_system_confuses_is_refused(project: Path, name: str, rule: str) -> None:
    index(project, ("100644", "x", f"submissions/{name}/submission.toml"))
    assert rule in [problem.rule for problem in checked(project).problems]


def test_a_submission_that_is_replaced_by_a_link_is_refused(project: Path) -> None:
    shutil.rmtree(project / "submissions" / "old")
    (project / "submissions" / "old").symlink_to("../scoring")
    commit(project)
    assert ("stray-file", "submissions/old") in rules(checked(project))


def test_a_submission_that_reaches_a_limit_is_refused(
    request_with_submission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gate, "READING", Limits(wall_seconds=0))
    report = checked(request_with_submission)
    assert [rule for rule, _ in rules(report)] == ["too-slow"]


@pytest.mark.usefixtures("in_this_process")
def test_an_equal_single_task_log_is_no_copy(request_with_submission: Path) -> None:
    """Methods that differ only between tasks have the same bytes there, by the same seeds."""
    path = "hopper-gravity/single/run0"
    for suffix in ("csv", "npz"):
        old = (request_with_submission / f"submissions/old/{path}.{suffix}").read_bytes()
        (request_with_submission / f"{NEW}/{path}.{suffix}").write_bytes(old)
    commit(request_with_submission)
    assert "copied-run" not in [rule for rule, _ in rules(checked(request_with_submission))]


def test_a_pull_request_without_a_change_or_a_common_ancestor_is_refused(project: Path) -> None:
    ((rule, where),) = rules(checked(project))
    assert (rule, len(where)) == ("no-change", 40), "the commit"
    git(project, "switch", "--quiet", "--orphan", "alone")
    commit(project, {"submissions/new/submission.toml": "x"})
    assert rules(checked(project)) == [("unrelated-history", "")]


def test_a_clone_that_lacks_the_common_ancestor_is_named(project: Path, tmp_path: Path) -> None:
    commit(project, {"submissions/old/README.md": "One text.\n"})
    git(project, "switch", "--quiet", "main")
    commit(project, {"scoring/rank.py": "rank = 3\n"})
    part = tmp_path / "part"
    options = ("--quiet", "--depth=1", "--no-single-branch")
    git(tmp_path, "clone", *options, f"file://{project}", str(part))
    with refused("shallow-clone"):
        checked(part, base="origin/main", head="origin/request")


def test_a_stray_file_alone_is_of_no_kind(project: Path) -> None:
    commit(project, {"submissions/README.md": "x"})
    report = checked(project)
    assert (report.kind, report.labels) == ("none", ["refused"])


def test_a_history_with_several_common_ancestors_is_refused(project: Path) -> None:
    """The merge of both sides of an old merge would revert what the base changed on its side."""
    git(project, "switch", "--quiet", "-c", "first", "main")
    first = commit(project, {"submissions/old/README.md": "x\n"})
    git(project, "switch", "--quiet", "main")
    second = commit(project, {"scoring/rank.py": "rank = 2\n"})
    git(project, "merge", "--quiet", "--no-edit", "first")
    tree = git(project, "rev-parse", f"{first}^{{tree}}")
    crossed = git(project, "commit-tree", tree, "-p", first, "-p", second, "-m", "crossed")
    git(project, "switch", "--quiet", "request")
    git(project, "reset", "--quiet", "--hard", crossed)
    (problem,) = checked(project).problems
    assert (problem.rule, problem.message) == ("crossed-history", "The two commits have 2 common ancestors.")


def test_an_edit_of_a_submission_that_the_base_changed_meanwhile_is_refused(project: Path) -> None:
    commit(project, {"submissions/old/README.md": "One text.\n"})
    git(project, "switch", "--quiet", "main")
    commit(project, {"submissions/old/README.md": "Another text.\n"})
    assert rules(checked(project, head="request")) == [("outdated-submission", "submissions/old")]


@pytest.mark.usefixtures("no_judge")
def test_a_new_submission_is_compared_with_the_base_where_it_started(project: Path) -> None:
    git(project, "switch", "--quiet", "main")
    commit(project, {"scoring/rank.py": "rank = 3\n"})
    assert checked(project, head="submission").verdict == "passed"
    git(project, "switch", "--quiet", "submission")
    git(project, "merge", "--quiet", "--no-edit", "main")
    assert checked(project).verdict == "passed", "a merge of the base changes nothing of the submission"


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


def test_a_clone_without_old_contents_is_named_and_no_pull_request_is_refused_for_it(
    project: Path, tmp_path: Path
) -> None:
    git(project, "config", "uploadpack.allowFilter", "true")
    part = tmp_path / "part"
    git(tmp_path, "clone", "--quiet", "--filter=blob:none", f"file://{project}", str(part))
    with refused("partial-clone", "git sparse-checkout add submissions/NAME"):
        checked(part, base="origin/main", head="origin/submission")


@pytest.mark.usefixtures("no_judge")
def test_a_clone_without_the_other_submissions_suffices_for_a_new_one(
    project: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    git(project, "config", "uploadpack.allowFilter", "true")
    part = tmp_path / "part"
    git(tmp_path, "clone", "--quiet", "--filter=blob:none", "--sparse", f"file://{project}", str(part))
    git(project, "switch", "--quiet", "submission")
    shutil.copytree(project / NEW, part / NEW)
    git(part, "add", "--sparse", NEW)
    git(part, "commit", "--quiet", "-m", "new")
    report = checked(part, base="origin/main")
    assert (report.verdict, report.notes[-1]) == (
        "passed",
        "Not compared: the titles of 1 submission, which this clone lacks.",
    )
    assert capfd.readouterr().err == ""


def test_a_clone_of_another_owner_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    git(tmp_path, "init", "--quiet")
    monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")
    with refused("distrusted-clone", "safe.directory"):
        checked(tmp_path)


def test_code_is_not_passed_where_no_box_can_be_started(
    request_with_submission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with (request_with_submission / NEW / "submission.toml").open("a", encoding="utf-8") as file:
        file.write('\n[agent]\nentry = "agent.py:make"\n')
    commit(request_with_submission, {f"{NEW}/agent/agent.py": "make = 1\n"})
    monkeypatch.setattr("platform.machine", lambda: "other")
    with refused("no-box", "A box needs Linux"):
        checked(request_with_submission, try_code=True)
