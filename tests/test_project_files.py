"""Files that describe the project: links, versions and workflows agree with the tree."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from gym_extensions.verification.episodes import HOURS

from .curation.repositories import commit, git, make_repository

ROOT = Path(__file__).resolve().parent.parent
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
FOLDERS = (".", "docs", "docs/adr", "docs/findings", "examples", "tools", "tools/tuning")
GUIDES = [path for folder in FOLDERS for path in sorted((ROOT / folder).glob("*.md"))]


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def anchors(text: str) -> set[str]:
    """Ids of the headings of a Markdown page, as code hosts and mkdocs make them."""
    headings = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading).strip().lower().replace(" ", "-") for heading in headings}


def jobs_of(workflow: Path) -> dict[str, str]:
    """The text of each job of a workflow."""
    jobs = workflow.read_text("utf-8").partition("\njobs:\n")[2]
    parts = re.split(r"^  (\w+):$", jobs, flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


def test_no_link_is_committed() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("not a clone")
    files = subprocess.run(
        ["git", "-c", "safe.directory=*", "ls-files", "-s"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert [line for line in files.stdout.splitlines() if line.startswith("120000")] == []


@pytest.mark.parametrize("page", GUIDES, ids=relative)
def test_relative_links_lead_to_files_and_headings(page: Path) -> None:
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
        if "://" in target:
            continue
        name, _, heading = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or (heading and heading not in anchors(file.read_text("utf-8"))):
            broken.append(target)
    assert broken == []


def test_the_architecture_names_every_module() -> None:
    """But for agents and rules, which have a module each, named after them."""
    text = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
    modules = [path for path in ROOT.glob("*/gym_extensions/**/*.py") if path.name != "__init__.py"]
    named = [path for path in modules if path.parent.name not in ("algorithms", "rules")]
    assert len(named) > 100
    assert [relative(path) for path in named if not re.search(rf"\b{path.stem}\b", text)] == []


def test_the_citation_has_the_version_of_pyproject() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert re.findall(r"^version: (\S+)$", citation, re.MULTILINE) == [project["version"]]


def test_the_matrix_tests_every_declared_python() -> None:
    classifiers = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["classifiers"]
    declared = [name.rpartition(" ")[2] for name in classifiers if re.search(r":: 3\.\d+$", name)]
    matrix = re.findall(r"python: \[(.*)\]", (ROOT / ".github/workflows/ci.yml").read_text("utf-8"))
    assert matrix == [", ".join(f'"{version}"' for version in declared)]


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=relative)
def test_actions_are_pinned_by_commit_and_the_token_can_only_read(workflow: Path) -> None:
    text = workflow.read_text("utf-8")
    uses = re.findall(r"uses: (.*)$", text, flags=re.MULTILINE)
    assert uses
    assert [
        use for use in uses if not re.fullmatch(r"[\w/-]+@[0-9a-f]{40} # v[\d.]+( # zizmor: .*)?", use)
    ] == []
    assert "\npermissions:\n  contents: read\n" in text or "\npermissions: {}\n" in text


def test_a_workflow_that_runs_on_untrusted_input_starts_without_permissions_and_runs_none_of_it() -> None:
    texts = {path.name: path.read_text("utf-8") for path in WORKFLOWS}
    privileged = {
        name
        for name, text in texts.items()
        if re.search("^  (pull_request_target|workflow_run):", text, flags=re.MULTILINE)
    }
    assert privileged == {"gate.yml", "gate-comment.yml"}
    assert all("\npermissions: {}\n" in texts[name] for name in privileged)
    for name, writing in (("gate.yml", []), ("train.yml", ["record"]), ("review.yml", ["record"])):
        jobs = jobs_of(ROOT / ".github/workflows" / name)
        assert ": write" not in texts[name]
        for secret in ("GH_TOKEN", "environment: record", "secrets."):
            assert [job for job, text in jobs.items() if secret in text] == writing
    bases = re.findall("(?:ref|BASE): (.*)", texts["gate.yml"])
    assert bases == ["${{ github.sha }}"] * 3, "not the older `pull_request.base.sha`"
    assert "github.event.pull_request.title" not in texts["gate.yml"]
    assert "\n    branches: [main]" in texts["gate.yml"], "no gate of another branch passes a pull request"


@pytest.mark.parametrize(
    ("command", "reads_old_files"),
    [("gym-extensions verify", False), ("maintain train-here", True), ("check-pr --base", True)],
)
def test_a_job_has_the_history_that_its_command_reads(command: str, reads_old_files: bool) -> None:
    """A clone with one commit is refused; so is one without the contents of older files, where they count."""
    jobs = {(path.name, job): text for path in WORKFLOWS for job, text in jobs_of(path).items()}
    named = {name: text for name, text in jobs.items() if command in text}
    assert len(named) > 1
    assert [name for name, text in named.items() if "fetch-depth: 0" not in text] == []
    assert [name for name, text in named.items() if reads_old_files and "filter: " in text] == []


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=relative)
def test_a_command_that_fails_fails_its_step(workflow: Path) -> None:
    """A shell ignores the status of a command inside of another one, unless that only assigns or compares."""
    lines = [line.strip() for line in workflow.read_text("utf-8").splitlines() if "$(" in line]
    allowed = r"""(run: )?(\w+=\$\(.*\)|test "\$\(.*\)" = [^)]+)"""
    assert [line for line in lines if not re.fullmatch(allowed, line)] == []


def test_the_step_that_verifies_is_longer_than_the_hours_of_a_submission() -> None:
    text = (ROOT / ".github/workflows/review.yml").read_text("utf-8")
    (minutes,) = re.findall(r"name: Verify.*\n +timeout-minutes: (\d+)", text)
    assert int(minutes) >= 60 * HOURS + 20
    written = re.findall("gym-extensions verify .* --record", text)
    assert ["--retrain" in each for each in written] == [False, True], "a long training loses no verdict"


@pytest.mark.skipif(sys.platform == "win32", reason="the shell of a job on Linux")
def test_a_job_reviews_its_own_submission_alone(tmp_path: Path) -> None:
    """Policies run in it. A review of another submission that it writes is not taken."""
    files = {f"submissions/{name}/submission.toml": "" for name in ("one", "two")}
    commit(make_repository(tmp_path), files)
    commands = {
        "gh": "mkdir -p found/review-one && touch found/review-one/one.toml found/review-one/two.toml",
        "gym-extensions": 'cp "$4" "$2/review.toml"',
    }
    for name, command in commands.items():
        path = tmp_path / ".git" / name
        path.write_text(f"#!/bin/sh\n{command}\n")
        path.chmod(0o755)
    job = jobs_of(ROOT / ".github/workflows/review.yml")["record"]
    steps = re.findall(r"^        run: (?:\|\n)?(.+\n(?:          .*\n)*)", job, flags=re.MULTILINE)
    assert len(steps) == 2
    environment = {**os.environ, "PATH": f"{tmp_path / '.git'}:{os.environ['PATH']}", "RUN_ID": "1"}
    for step in steps:
        subprocess.run(["bash", "-e", "-c", step], cwd=tmp_path, env=environment, check=False)
    assert git(tmp_path, "show", "--format=", "--name-only") == "submissions/one/review.toml"


def test_the_comment_follows_only_the_gate_of_the_main_branch() -> None:
    """A pull request can add a workflow that is named like the gate."""
    text = (ROOT / ".github/workflows/gate-comment.yml").read_text("utf-8")
    (condition,) = re.findall(r"^    if: >-\n((?:      .*\n)+)", text, flags=re.MULTILINE)
    assert [part.strip().removesuffix(" &&") for part in condition.splitlines()] == [
        "github.event.workflow_run.event == 'pull_request_target'",
        "github.event.workflow_run.path == '.github/workflows/gate.yml'",
        "github.event.workflow_run.conclusion != 'cancelled'",
    ]


def test_the_tests_that_jobs_name_exist() -> None:
    texts = [path.read_text("utf-8") for path in (ROOT / "Makefile", *WORKFLOWS)]
    named = {path for text in texts for path in re.findall(r"tests/[\w/]+(?:\.\w+)?", text)}
    assert len(named) > 5
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


def test_ci_runs_the_slow_tests_of_what_runs_strangers_code() -> None:
    text = (ROOT / ".github/workflows/ci.yml").read_text("utf-8")
    commands = [line for line in text.splitlines() if "--no-skips -m 'slow or not slow'" in line]
    assert {path for line in commands for path in re.findall(r"tests/[\w/]+", line)} >= {
        "tests/curation",
        "tests/baselines/isolated",
    }
