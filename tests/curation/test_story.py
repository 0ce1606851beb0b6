"""The whole story with git repositories: a stranger's fork, the gate, the merge, the review, the level."""

import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from gym_extensions.baselines import train
from gym_extensions.catalog.groups import group
from gym_extensions.curation.cli import maintain
from gym_extensions.curation.gate import check_pull_request
from gym_extensions.curation.gate_report import GateReport
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring.ranking.group_board import boards
from gym_extensions.scoring.submission.scorer import score
from gym_extensions.submissions.policies.files import policy_keys
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import read_review
from gym_extensions.submissions.run import read_run
from gym_extensions.verification.cli import main as verify
from gym_extensions.verification.git import Repository

from ..conftest import run_jobs_here
from ..verification import made_submissions as submissions
from ..verification.made_submissions import (
    GROUP,
    change_document,
    change_documents,
    change_log,
    copy,
    honest,
    level_of,
)
from .repositories import commit, git, make_repository, merge, rules

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")

DECISION = """
[[decisions]]
action = "accepted"
by = "Somebody"
date = "2026-01-01"
reason = "None"
"""
REASON = ("--by", "A. Maintainer", "--reason", "A reason.")
REFERENCES = References(
    "synthetic", {task: Reference(Floor(-1000.0), Expert(1000.0)) for task in group(GROUP).task_ids}, "0" * 64
)


class Project:
    """The repository of the boards, and a stranger's fork of it: new, or a copy of those in ``original``."""

    def __init__(self, folder: Path, original: Path | None = None) -> None:
        self.main, self.fork = folder / "main", folder / "fork"
        if original is None:
            commit(make_repository(self.main), {"scoring/rank.py": "rank = 1\n"})
            git(folder, "clone", "--quiet", str(self.main), str(self.fork))
        else:
            shutil.copytree(original, folder, dirs_exist_ok=True)
            git(self.fork, "remote", "set-url", "origin", str(self.main))
        self.records = folder / "records"
        self.options = ("--cache", str(submissions.CACHE))

    def submit(self, submission: Path) -> GateReport:
        """The gate's report on a branch of the fork with a submission ``new``."""
        git(self.fork, "switch", "--quiet", "-c", "submission")
        shutil.copytree(submission, self.fork / "submissions" / "new")
        return self.check("submission")

    def check(self, branch: str) -> GateReport:
        """Commits a branch of the fork, and gives the gate's report on it."""
        commit(self.fork)
        git(self.main, "fetch", "--quiet", str(self.fork), f"+{branch}:refs/gate/head")
        return check_pull_request(Repository(self.main), "main", "refs/gate/head")

    def donate(self, start: str, run: int, seed: int, **changes: object) -> GateReport:
        """The gate's report on a branch with one run more of ``new``, from a commit of main."""
        git(self.fork, "fetch", "--quiet", "origin")
        git(self.fork, "switch", "--quiet", "-c", f"run{run}-{seed}", start)
        submission = self.fork / "submissions" / "new"
        keys = policy_keys("sequential", group(GROUP))
        policies = {key: submissions.network(100 * seed + number) for number, key in enumerate(keys)}
        submissions.write_run_files(submission, "sequential", run, policies)
        document = submission / GROUP / "sequential" / f"run{run}.json"
        change_document(document, by="A. Donor", **changes)
        if changes.get("policies", ...) is None:
            document.with_suffix(".npz").unlink()
        return self.check(f"run{run}-{seed}")

    def merge(self) -> Path:
        """Merges the branch and gives the submission."""
        git(self.main, "merge", "--quiet", "--no-ff", "--no-edit", "refs/gate/head")
        return self.main / "submissions" / "new"

    def review(self, submission: Path, *options: str) -> str:
        """Runs both jobs of the review on main, commits the review, and gives the submission's level."""
        record = self.records / "new.toml"
        record.unlink(missing_ok=True)
        verify([str(submission), *self.options, *options, "--record", str(self.records)])
        if record.exists():
            assert verify([str(submission), "--take", str(record)]) == 0
            assert git(self.main, "status", "--porcelain").split()[1] == "submissions/new/review.toml"
        commit(self.main, message="review")
        return level_of(submission)


def test_an_honest_submission_gets_a_rank_with_one_pull_request(tmp_path: Path) -> None:
    project = Project(tmp_path)
    report = project.submit(honest())
    assert (report.verdict, report.level) == ("passed", "claimed")
    assert report.repeated == report.episodes == 400, "20 cells of 20 episodes"
    submission = project.merge()
    assert level_of(submission) == "claimed"
    merge = git(project.main, "rev-parse", "HEAD")
    assert project.review(submission) == "verified"
    assert read_review(submission).verifications[0].value == merge
    scored = boards([score(read(submission), REFERENCES)]).boards
    (board,) = [each for each in scored if (each.group, each.protocol) == (f"{GROUP}-v0", "sequential")]
    assert [(row.name, row.ranked, row.level) for row in board.rows] == [("new", True, "verified")]
    assert project.review(submission) == "verified", "nothing is drawn again"
    assert len(read_review(submission).verifications) == 1


@pytest.fixture
def project(tmp_path: Path, in_this_process: None) -> Project:
    """A project without submissions; the test before runs policies in processes with limits, these do not."""
    return Project(tmp_path)


@pytest.fixture(scope="module")
def verified(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a project with a verified submission ``new`` of an agent of this project."""
    folder = tmp_path_factory.mktemp("verified")
    submission = copy(honest(), tmp_path_factory.mktemp("of") / "trpo")
    manifest = submission / "submission.toml"
    manifest.write_text(manifest.read_text("utf-8").replace('"formula"', '"trpo"'), "utf-8")
    project = Project(folder)
    with pytest.MonkeyPatch.context() as patch:
        run_jobs_here(patch)
        project.submit(submission)
        assert project.review(project.merge()) == "verified"
    return folder


@pytest.fixture
def with_submission(verified: Path, tmp_path: Path, in_this_process: None) -> Project:
    """A copy of that project."""
    return Project(tmp_path, verified)


def test_a_stranger_donates_a_run_which_alone_is_verified(with_submission: Project) -> None:
    report = with_submission.donate("origin/main", 5, 5)
    assert (report.kind, report.verdict, report.labels) == ("donation", "passed", ["claimed", "donation"])
    assert report.repeated == report.episodes == 120, "the six cells of the donated run"
    submission = with_submission.merge()
    assert with_submission.review(submission) == "verified"
    assert list(read_review(submission).verifications[-1].runs) == [f"{GROUP}/sequential/run5"]
    score_ = score(read(submission), REFERENCES).groups[f"{GROUP}-v0"]["sequential"]
    assert [run.by for run in score_.provenance] == ["", "", "", "", "", "A. Donor"]


def test_a_donated_run_after_a_gap_waits_and_changes_no_score(with_submission: Project) -> None:
    before = score(read(with_submission.main / "submissions" / "new"), REFERENCES)
    assert with_submission.donate("origin/main", 7, 7).verdict == "passed"
    submission = with_submission.merge()
    after = score(read(submission), REFERENCES)
    assert after.groups == before.groups
    assert after.notes == (f"{GROUP}-v0: sequential: run 5 is missing; until it is there, not scored: 7.",)


def test_two_donations_of_a_run_that_differ_are_refused_by_name(with_submission: Project) -> None:
    start = git(with_submission.main, "rev-parse", "HEAD")
    assert with_submission.donate("origin/main", 5, 5).verdict == "passed"
    with_submission.merge()
    second = with_submission.donate(start, 5, 6)
    assert (second.kind, {problem.rule for problem in second.problems}) == ("donation", {"donated-twice"})
    assert "with other content" in second.problems[0].message
    assert with_submission.donate(start, 6, 6).verdict == "passed", "another run of the same time"
    assert {problem.rule for problem in with_submission.donate(start, 7, 5).problems} == {"copied-run"}


def test_a_bad_run_refuses_no_run_of_another_merge_and_can_be_reverted(with_submission: Project) -> None:
    with_submission.donate("origin/main", 5, 5)
    change_log(with_submission.fork / "submissions/new", lambda row: {"return": row["return"] * 3 + 9}, 5)
    with_submission.check("run5-5")
    submission = with_submission.merge()
    with_submission.donate("origin/main", 6, 6)
    with_submission.merge()
    assert with_submission.review(submission) == "claimed"
    verifications = read_review(submission).verifications[1:]
    assert [(len(each.runs), each.passed) for each in verifications] == [(1, False), (1, True)]
    for path in submission.glob(f"{GROUP}/sequential/run5.*"):
        path.unlink()
    assert level_of(submission) == "verified"


def test_a_donated_run_of_another_agent_is_refused_by_name(with_submission: Project) -> None:
    own = read_run(with_submission.main / f"submissions/new/{GROUP}/sequential/run0.json")
    versions = own.versions
    cases: tuple[tuple[str, dict[str, object]], ...] = (
        ("other-agent-version", {"versions": msgspec.structs.replace(versions, gym_extensions="0.9")}),
        ("other-agent-version", {"steps": own.steps * 94 // 100}),
        ("no-policies", {"policies": None}),
    )
    patch = msgspec.structs.replace(
        versions, gym_extensions=".".join([*versions.gym_extensions.split(".")[:2], "9"])
    )
    like = {"versions": patch, "steps": own.steps * 96 // 100}
    assert with_submission.donate("origin/main", 5, 9, **like).verdict == "passed"
    for seed, (rule, changes) in enumerate(cases, 5):
        report = with_submission.donate("origin/main", 5, seed, **changes)
        assert [(each.rule, each.where) for each in report.problems] == [(rule, f"{GROUP}/sequential/run5")]


def test_a_donation_with_a_problem_is_told_it(with_submission: Project) -> None:
    with_submission.donate("origin/main", 5, 5)
    log = with_submission.fork / f"submissions/new/{GROUP}/sequential/run5.csv"
    log.write_bytes(log.read_bytes().replace(b"\n", b"\r\n"))
    found = rules(with_submission.check("run5-5"))
    assert ("malformed-log", f"{GROUP}/sequential/run5.csv, line 1") in found


def test_a_donation_from_before_an_edit_is_judged_with_the_edited_submission(
    with_submission: Project,
) -> None:
    start = git(with_submission.main, "rev-parse", "HEAD")
    change_documents(
        with_submission.main / "submissions/new",
        lambda document: {"versions": msgspec.structs.replace(document.versions, gym_extensions="9.0")},
    )
    commit(with_submission.main)
    report = with_submission.donate(start, 5, 5)
    assert (report.kind, [each.rule for each in report.problems]) == ("donation", ["other-agent-version"])


def test_a_run_of_an_agent_of_a_stranger_is_an_edit(project: Project) -> None:
    project.submit(honest(runs=2))
    project.merge()
    assert project.donate("origin/main", 2, 5).kind == "edit"


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the agent ``random``."""
    folder = tmp_path_factory.mktemp("random") / "trained"
    train("random", GROUP, "sequential", "smoke", 0, out=folder)
    shutil.rmtree(folder / ".progress")
    return folder


def test_the_job_trains_a_run_of_an_agent_of_this_project_again(project: Project, trained: Path) -> None:
    project.submit(trained)
    submission = project.merge()
    assert project.review(submission, "--retrain") == "verified"
    assert read_review(submission).verifications[0].retrained == [f"{GROUP}/sequential/run0"]


def test_a_training_that_cannot_be_repeated_leaves_what_was_verified(
    project: Project, trained: Path, tmp_path: Path
) -> None:
    manifest = copy(trained, tmp_path / "trained") / "submission.toml"
    manifest.write_text(manifest.read_text().replace("[hyperparameters]", "[hyperparameters]\nrate = 1"))
    project.submit(tmp_path / "trained")
    assert project.review(project.merge(), "--retrain") == "verified"


def test_a_maintainer_decides_by_name_and_reason(tmp_path: Path) -> None:
    submission = copy(honest(runs=2), tmp_path / "new")
    for action in ("accepted", "challenged"):
        assert maintain(["decide", str(submission), action, *REASON]) == 0
    assert maintain(["decide", str(submission), "withdrawn", "--by", "A. Maintainer", "--reason", " "]) == 2
    with pytest.raises(SystemExit):
        maintain(["decide", str(submission), "withdrawn", "--by", "A. Maintainer"])
    assert [each.action for each in read_review(submission).decisions] == ["accepted", "challenged"]


def higher(submission: Path) -> None:
    change_log(submission, lambda row: {"return": row["return"] * 1.2 + 5})


def of_the_first_arithmetic(submission: Path) -> None:
    change_documents(submission, lambda _: {"arithmetic": 1})


@pytest.mark.parametrize(
    ("forge", "rule"), [(higher, "not-repeated"), (of_the_first_arithmetic, "first-arithmetic")]
)
def test_a_forgery_is_refused_by_the_gate(
    tmp_path: Path, project: Project, forge: Callable[[Path], None], rule: str
) -> None:
    submission = copy(honest(runs=2), tmp_path / "new")
    forge(submission)
    assert {problem.rule for problem in project.submit(submission).problems} == {rule}


def test_a_record_of_other_files_or_seeds_is_not_taken(
    project: Project, capsys: pytest.CaptureFixture[str]
) -> None:
    project.submit(honest(runs=2))
    submission = project.merge()
    verify([str(submission), *project.options, "--record", str(project.records)])
    record = project.records / "new.toml"
    text = record.read_text()
    value = git(project.main, "rev-parse", "HEAD")
    forged = {
        "seeds do not follow": text.replace(value, "3f" * 20),
        "about other files": re.sub(r'(sequential/run0" = )"\w{64}"', rf'\1"{"0" * 64}"', text),
        "about other": text.partition("\n[verifications.files]")[0],
        "trained again that no job trains": text.replace(
            "retrained = []", f'retrained = ["{GROUP}/sequential/run0"]'
        ),
        "or decisions": text + DECISION,
        "has no verification": "",
    }
    for reason, content in forged.items():
        record.write_text(content)
        assert verify([str(submission), "--take", str(record)]) == 2
        assert reason in capsys.readouterr().err
    assert not (submission / "review.toml").exists()


def test_a_folder_that_does_not_exist_is_named(tmp_path: Path) -> None:
    typo = str(tmp_path / "typo")
    assert maintain(["landscapes", typo]) == maintain(["decide", typo, "accepted", *REASON]) == 2
    assert verify([typo]) == 2


def test_a_folder_of_several_submissions_is_not_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("one", "two"):
        copy(honest(runs=2), tmp_path / name)
    for words in (["decide", str(tmp_path), "accepted", *REASON], ["train-here", str(tmp_path)]):
        assert maintain(words) == 2
        assert "It has 2 submissions. Name one of them." in capsys.readouterr().err


def test_a_job_lists_what_waits_for_a_review_the_newest_last(
    with_submission: Project, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = with_submission.main / "submissions"
    capsys.readouterr()
    assert verify([str(folder), "--due"]) == 0
    assert capsys.readouterr().out == "[]\n"
    with_submission.donate("origin/main", 5, 5)
    with_submission.merge()
    manifest = (folder / "new/submission.toml").read_text()
    shutil.copytree(folder / "new", folder / "a-later-one", ignore=shutil.ignore_patterns("review.toml"))
    (folder / "a-later-one/submission.toml").write_text(manifest.replace("A submission", "Another"))
    assert verify([str(folder), "--due"]) == 0
    printed = capsys.readouterr()
    assert (printed.out, "not committed in its present form" in printed.err) == ('["new"]\n', True)
    monkeypatch.setenv("GIT_COMMITTER_DATE", "2040-01-01T00:00:00")
    merge(with_submission.main, {})
    shutil.copytree(folder / "a-later-one", folder / "of-no-merge")
    (folder / "of-no-merge/submission.toml").write_text(manifest.replace("A submission", "A third"))
    commit(with_submission.main)
    assert verify([str(folder), "--due"]) == 0
    assert capsys.readouterr().out == '["new", "a-later-one"]\n'
    (folder / "a-later-one/submission.toml").write_text(manifest.replace("[observes]", "[observe]"))
    assert verify([str(folder), "--due"]) == 0
    printed = capsys.readouterr()
    assert (printed.out, printed.err[:25]) == ('["new"]\n', "a-later-one is left out: ")


def test_a_fast_forward_merge_gives_no_seeds(
    with_submission: Project, capsys: pytest.CaptureFixture[str]
) -> None:
    with_submission.donate("origin/main", 5, 5)
    git(with_submission.main, "merge", "--quiet", "--ff-only", "refs/gate/head")
    submission = with_submission.main / "submissions/new"
    capsys.readouterr()
    assert with_submission.review(submission) == "claimed"
    assert "no-merge: It is no merge but a fast-forward" in capsys.readouterr().out
    assert verify([str(submission), *with_submission.options, "--seeds", "7a" * 20, "--write"]) == 0
    assert level_of(submission) == "verified"
