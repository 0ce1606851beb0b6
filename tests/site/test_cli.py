"""``gym-extensions site`` scores folders of logs and builds their pages."""

import os
import subprocess
from pathlib import Path

import pytest

from gym_extensions import references
from gym_extensions.__main__ import main
from gym_extensions.scoring import pipeline
from gym_extensions.scoring.pipeline import score_folders

from ..conftest import loaded
from .made_submissions import REFERENCES, make_submission

NO_ADDRESSES = (
    "These pages name no repository (--repository ADDRESS) and no address of their own (--url ADDRESS)."
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory; every task of hopper-gravity has the floor 0 and the expert 100."""
    monkeypatch.chdir(tmp_path)
    for module in (pipeline, references):
        monkeypatch.setattr(module, "load_references", lambda: REFERENCES)
    return tmp_path


def test_submissions_are_built_into_the_folder_site_by_default(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_submission(folder / "submissions", "alpha")
    make_submission(folder / "submissions", "beta")
    assert main(["site"]) == 0
    out = capsys.readouterr().out
    assert out.splitlines() == [NO_ADDRESSES, "_site/index.html"]
    page = folder / "_site" / "boards" / "hopper-gravity-v0-sequential-100k.html"
    # 50 + mean(0 … 19) / 7 + run, over 100: .5136 and .5236; 12.706 · .00707 / √2 = .0635 on both sides.
    rows = page.read_text(encoding="utf-8").split("<tr")
    assert sum(">0.519 ±0.064</a><td>" in row for row in rows) == 2  # one row per submission
    assert "Alpha" in page.read_text(encoding="utf-8")
    assert "Beta" in page.read_text(encoding="utf-8")


def test_a_refused_submission_is_printed_with_all_problems_and_the_exit_status_is_1(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_submission(folder / "submissions", "alpha")
    broken = make_submission(folder / "submissions", "beta")
    log = broken / "hopper-gravity" / "sequential" / "run1.csv"
    log.write_text("\n".join(log.read_text(encoding="utf-8").splitlines()[:-1]) + "\n", encoding="utf-8")
    (broken / "[red]:smile:.txt").write_text("unexpected", encoding="utf-8")
    assert main(["site"]) == 1
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "_site/index.html"
    printed = " ".join(out.split("Refused ")[1].split())
    assert "(not on a board until all problems are fixed): beta Beta (3 problems)" in printed
    (card,) = score_folders([broken]).submissions
    assert len(card.problems) == 3
    for problem in card.problems:
        line = f"{problem.rule} {problem.where}: {problem.message} {problem.hint}"
        assert " ".join(line.split()) in printed
    assert "alpha" not in printed
    assert "19 of 20 episodes" in (folder / "_site/submissions/beta.html").read_text(encoding="utf-8")


def test_a_missing_folder_is_a_usage_error(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["site", "submission"]) == 2
    assert capsys.readouterr().err.startswith("error: submission: ")
    assert not (folder / "_site").exists()


def test_a_folder_without_submissions_is_not_a_refused_submission(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "submissions").mkdir()
    (folder / "submissions" / "README.md").write_text("Submissions go here.", encoding="utf-8")
    assert main(["site"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert [out[0], out[-1]] == ["submissions contains no submissions.", "_site/index.html"]
    page = (folder / "_site" / "index.html").read_text(encoding="utf-8")
    assert "There are no submissions yet." in page
    assert "Refused" not in page


def test_an_output_folder_that_is_not_a_built_site_is_a_usage_error(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alpha = make_submission(folder, "alpha")
    assert main(["site", "alpha", "--out", "alpha"]) == 2
    assert "does not contain a built site" in capsys.readouterr().err
    assert (alpha / "submission.toml").is_file()


def test_the_command_needs_no_simulator(folder: Path) -> None:
    make_submission(folder / "submissions", "submission")
    program = "from gym_extensions.__main__ import main; assert main(['site']) == 0"
    assert loaded(program, "mujoco gymnasium torch") == []


def test_pages_name_the_commit_of_the_data_and_the_repository(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_submission(folder / "submissions", "alpha")
    git = ["git", "-c", "user.name=A", "-c", "user.email=a@example.org"]
    dated = {**os.environ, "GIT_COMMITTER_DATE": "2026-01-02T12:00:00Z"}
    for command in (["init", "-q"], ["add", "."], ["commit", "-qm", "Data"]):
        subprocess.run([*git, *command], check=True, env=dated)
    commit = subprocess.run(
        ["git", "rev-parse", "HEAD"], check=True, capture_output=True, text=True
    ).stdout.strip()
    assert main(["site", "--repository", "https://example.org/a/b/", "--url", "https://example.org"]) == 0
    assert capsys.readouterr().out == "_site/index.html\n"
    assert 'xml:base="https://example.org/"' in (folder / "_site/feed.xml").read_text("utf-8")
    assert 'startsWith("https://example.org/")' in (folder / "_site/404.html").read_text("utf-8")
    for path, links in {"index.html": "submissions", "submissions/alpha.html": "submissions/alpha"}.items():
        page = (folder / "_site" / path).read_text("utf-8")
        assert "Data of <time>2026-01-02</time>" in page
        assert f'href="https://example.org/a/b/tree/{commit}/{links}"' in page
        assert f'"og:url" content="https://example.org/{path}"' in page
        assert '"og:image" content="https://example.org/pictures/hopper.webp"' in page
        assert "no public address" not in page
    citation = (folder / "_site/submissions/alpha/citation.bib").read_text("utf-8")
    assert r"\url{https://example.org/submissions/alpha.html}" in citation
    (folder / "submissions" / "alpha" / "README.md").write_text("More.", encoding="utf-8")
    assert main(["site"]) == 0
    page = (folder / "_site" / "index.html").read_text("utf-8")
    assert "with local changes" in page
    assert "og:image" not in page
    assert "this copy has no public address" in page


@pytest.mark.parametrize(
    "address", ["nothing", "git@example.org:a/b", "https://example.org", "ftp://example.org/a"]
)
def test_an_address_that_is_none_is_refused_before_anything_is_built(
    folder: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["site", "--repository", address])
    assert "no address such as https://example.org/owner/name" in capsys.readouterr().err
    assert not (folder / "_site").exists()
