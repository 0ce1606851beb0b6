"""``gym-extensions site`` scores folders of logs and builds their pages."""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gym_extensions import references
from gym_extensions.__main__ import main
from gym_extensions.catalog.groups import group
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.scoring import pipeline
from gym_extensions.scoring.pipeline import score_folders
from gym_extensions.site import cli
from gym_extensions.site.play import assets

from ..conftest import MANIFEST, loaded, write_submission

HOPPER = "hopper-gravity"
REFERENCES = References(
    "made-up", {task: Reference(Floor(0.0), Expert(100.0)) for task in group(HOPPER).task_ids}, "0f" * 32
)
"""Floor 0 and expert 100 on every task of the group."""


def value(_protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    """Returns of about 20, and of about 50 from the training on the task on."""
    return 20.0 + 30 * (stage >= position) + run + episode / 7


def make_submission(name: str) -> Path:
    """A sequential submission on hopper-gravity with the budget 100k in the working directory."""
    title = f'title = "{name.title()}"'
    return write_submission(
        Path("submissions"),
        name=name,
        protocols=("sequential",),
        value=value,
        manifest=MANIFEST.replace('"smoke"', '"100k"').replace('title = "A submission"', title),
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory; every task of hopper-gravity has the floor 0 and the expert 100."""
    monkeypatch.chdir(tmp_path)
    for module in (pipeline, references):
        monkeypatch.setattr(module, "load_references", lambda: REFERENCES)
    return tmp_path


def page_of(folder: Path, path: str) -> str:
    return (folder / "_site" / path).read_text("utf-8")


def test_submissions_are_built_into_the_folder_site_by_default(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_submission("alpha"), make_submission("beta")
    assert main(["site"]) == 0
    warning, last = capsys.readouterr().out.splitlines()
    assert ("--repository ADDRESS" in warning, last) == (True, "_site/index.html")
    page = page_of(folder, "boards/hopper-gravity-v0-sequential-100k.html")
    # 50 + mean(0 … 19) / 7 + run, over 100: .5136 and .5236; 12.706 · .00707 / √2 = .0635 on both sides.
    assert sum(">0.519 ±0.064</a><td>" in row for row in page.split("<tr")) == 2  # one row per submission
    assert "Alpha" in page and "Beta" in page


def test_a_refused_submission_is_printed_with_all_problems_and_the_exit_status_is_1(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_submission("alpha")
    broken = make_submission("beta")
    log = broken / "hopper-gravity" / "sequential" / "run1.csv"
    log.write_text("\n".join(log.read_text(encoding="utf-8").splitlines()[:-1]) + "\n", encoding="utf-8")
    (broken / "[red]:smile:.txt").write_text("unexpected", encoding="utf-8")
    assert main(["site"]) == 1
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "_site/index.html"
    printed = " ".join(out.split("Refused ")[1].split())
    assert "beta Beta (3 problems)" in printed and "alpha" not in printed
    (card,) = score_folders([broken]).submissions
    assert len(card.problems) == 3
    for problem in card.problems:
        line = f"{problem.rule} {problem.where}: {problem.message} {problem.hint}"
        assert " ".join(line.split()) in printed
    assert "19 of 20 episodes" in page_of(folder, "submissions/beta.html")


@pytest.mark.parametrize("kind", ["poses", "landscapes", "diagnostics"])
def test_a_file_that_cannot_be_read_is_named_and_the_submission_is_shown_without_it(
    folder: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = make_submission("alpha") / kind / f"{HOPPER}.json"
    file.parent.mkdir()
    file.write_text('{"format": 1', encoding="utf-8")
    assert main(["site"]) == 1
    out = capsys.readouterr().out
    assert f"because of {file}: It cannot be read" in out.replace("\n", "") and "Refused" not in out
    assert "Alpha" in page_of(folder, "boards/hopper-gravity-v0-sequential-100k.html")


def test_a_folder_without_submissions_is_not_a_refused_submission(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "submissions").mkdir()
    (folder / "submissions" / "README.md").write_text("Submissions go here.", encoding="utf-8")
    assert main(["site"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert [out[0], out[-1]] == ["submissions contains no submissions.", "_site/index.html"]
    page = page_of(folder, "index.html")
    assert ("There are no submissions yet." in page, "Refused" in page) == (True, False)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("submission", "error: submission: "),
        ("submissions --out submissions/a", "does not contain a built site"),
    ],
)
def test_a_missing_or_wrong_folder_is_a_usage_error(
    folder: Path, arguments: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = make_submission("a") / "submission.toml"
    assert main(["site", *arguments.split()]) == 2
    assert told in capsys.readouterr().err
    assert (kept.is_file(), (folder / "_site").exists()) == (True, False)


def test_the_command_needs_no_simulator(folder: Path) -> None:
    make_submission("submission")
    program = "from gym_extensions.__main__ import main; assert main(['site']) == 0"
    assert loaded(program, "mujoco gymnasium torch") == []


def test_processes_start_after_mujoco_is_read_and_before_a_thread_draws(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    called = []

    def recorded(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            called.append(function.__name__)
            return function(*arguments)

        return call

    for module, name in ((assets, "load"), (cli, "working"), (pipeline, "scorecards")):
        monkeypatch.setattr(module, name, recorded(getattr(module, name)))
    (folder / "submissions").mkdir()
    assert main(["site"]) == 0
    assert called == ["load", "scorecards", "working"]


def test_pages_name_the_commit_of_the_data_and_the_repository(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alpha = make_submission("alpha")
    git = ["git", "-c", "user.name=A", "-c", "user.email=a@example.org"]
    dated = {**os.environ, "GIT_COMMITTER_DATE": "2026-01-02T12:00:00Z"}
    for command in (["init", "-q"], ["add", "."], ["commit", "-qm", "Data"]):
        subprocess.run([*git, *command], check=True, env=dated)
    commit = subprocess.check_output(["git", "rev-parse", "HEAD"], text=True).strip()
    assert main(["site", "--repository", "https://example.org/a/b/", "--url", "https://example.org"]) == 0
    assert capsys.readouterr().out == "_site/index.html\n"
    assert 'xml:base="https://example.org/"' in page_of(folder, "feed.xml")
    assert 'startsWith("https://example.org/")' in page_of(folder, "404.html")
    for path, links in {"index.html": "submissions", "submissions/alpha.html": "submissions/alpha"}.items():
        page = page_of(folder, path)
        assert "Data of <time>2026-01-02</time>" in page
        assert f'href="https://example.org/a/b/tree/{commit}/{links}"' in page
        assert f'"og:url" content="https://example.org/{path}"' in page
        assert '"og:image" content="https://example.org/pictures/hopper.webp"' in page
    assert r"\url{https://example.org/submissions/alpha.html}" in page_of(
        folder, "submissions/alpha/citation.bib"
    )
    (alpha / "README.md").write_text("More.", encoding="utf-8")
    assert main(["site"]) == 0
    page = page_of(folder, "index.html")
    assert "with local changes" in page and "this copy has no public address" in page
    assert "og:image" not in page


@pytest.mark.parametrize(
    "address", ["nothing", "git@example.org:a/b", "https://example.org", "ftp://example.org/a", "http://["]
)
def test_an_address_that_is_none_is_refused_before_anything_is_built(
    folder: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["site", "--repository", address])
    assert "no address such as https://example.org/owner/name" in capsys.readouterr().err
    assert not (folder / "_site").exists()
