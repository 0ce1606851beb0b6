"""The options of each documented command exist, and the documented files and programs work."""

import argparse
import importlib
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.__main__ import main
from gym_extensions.catalog.protocol import BUDGETS
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import review_of, training_of

from .conftest import module_of

ROOT = Path(__file__).resolve().parents[1]
FURTHER = ("docs/environments/README.md", "tools/tuning/README.md")
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / name for name in FURTHER)])
BLOCK = re.compile(r"^```(?P<language>\w*)\n(?P<code>.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"(?:gym-extensions|score|make|pip|python) \S")


class ParsedError(Exception):
    """The options were parsed; nothing else of the command ran."""


def blocks(page: Path, *languages: str) -> list[str]:
    text = page.read_text(encoding="utf-8")
    return [block["code"] for block in BLOCK.finditer(text) if block["language"] in languages]


def commands(page: Path) -> list[str]:
    """The lines of the blocks without a language that are commands."""
    code = "".join(blocks(page, "", "bash", "sh")).replace("\\\n", " ")
    return [line for line in code.splitlines() if COMMAND.match(line)]


OTHER_PROGRAMS = "libraries.md"
"""The page with commands of other projects, which tests/test_libraries.py runs where they are installed."""
TEMPLATES = "".join(page.read_text("utf-8") for page in (ROOT / "site").rglob("templates/*.html"))
ON_SITE = {" ".join(code.split()) for code in re.findall(r"<code>([^<{]+)</code>", TEMPLATES)}
"""The code on the pages of the board that has no variable."""
COMMANDS = sorted(
    {command for page in PAGES if page.name != OTHER_PROGRAMS for command in commands(page)}
    | set(filter(COMMAND.match, ON_SITE))
)


def program(words: list[str]) -> tuple[Callable[[list[str]], object], list[str]]:
    """The function behind a command line, and its arguments."""
    if words[:2] == ["python", "-m"]:
        is_package = hasattr(importlib.import_module(words[2]), "__path__")
        return importlib.import_module(words[2] + ".__main__" * is_package).main, words[3:]
    if words[0] == "python":
        return module_of(ROOT / words[1]).main, words[2:]
    return main, words[1:] if words[0] == "gym-extensions" else words


@pytest.mark.parametrize(
    "command", [line for line in COMMANDS if line.split()[0] in {"gym-extensions", "score", "python"}]
)
def test_a_command_has_options_that_exist(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    parse = argparse.ArgumentParser.parse_args

    def stop_after(self: argparse.ArgumentParser, args: list[str] | None = None) -> None:
        parse(self, args)
        raise ParsedError

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", stop_after)
    function, arguments = program(shlex.split(command, comments=True))
    with pytest.raises(ParsedError):
        function(arguments)


@pytest.mark.parametrize("command", [line for line in COMMANDS if line.startswith(("make ", "pip "))])
def test_targets_extras_and_files_of_a_command_exist(command: str) -> None:
    words = shlex.split(command, comments=True)
    if words[0] == "make":
        targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text("utf-8"), flags=re.MULTILINE)
        assert words[-1] in targets
        return
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    named = [name for word in words for names in re.findall(r"\[(.*)\]", word) for name in names.split(",")]
    assert set(named) <= set(extras)
    files = [words[index + 1] for index, word in enumerate(words) if word == "-c"]
    assert all((ROOT / file).exists() for file in files)


def test_the_documented_manifest_breaks_no_rule(make_submission: Callable[..., Path]) -> None:
    manifest, *_ = blocks(ROOT / "docs/rollout-log.md", "toml")
    manifest = manifest.replace('"https://…"', '"https://example.org/mine"')
    folder = make_submission(manifest=manifest)
    (folder / "agent").mkdir()
    (folder / "agent/agent.py").write_text("make = None\n", "utf-8")
    assert read(folder).problems == ()


def test_the_documented_review_and_training_can_be_read() -> None:
    _, review, training = blocks(ROOT / "docs/rollout-log.md", "toml")
    review = review.replace('value = "9f0c…"', f'value = "{"9f" * 20}"')
    (part,) = review_of(review.replace('run0" = "…"', f'run0" = "{"0" * 64}"').encode()).verifications
    assert (part.repeated, part.passed) == (part.episodes, True)
    training = training.replace('"3f0a…"', f'"{"3f" * 20}"').replace('agent = "…"', f'agent = "{"0" * 64}"')
    found = training_of(training.replace('run0" = "…"', f'run0" = "{"0" * 64}"').encode())
    assert (len(found.runs), len(found.failed)) == (1, 1)


def test_the_documented_way_to_a_policy_leads_to_an_action(
    make_submission: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    (code,) = blocks(ROOT / "docs/rollout-log.md", "python")
    folder = make_submission(name="submissions/trpo", runs=(0,))
    monkeypatch.chdir(folder.parents[1])
    names: dict[str, object] = {}
    exec(code.replace("act(observation)", "act(observation, np.random.default_rng(0))"), {"np": np}, names)
    assert getattr(names["action"], "shape", None) == (3,)


def test_the_page_on_submitting_has_every_budget() -> None:
    text = (ROOT / "docs/agents.md").read_text("utf-8")
    rows = {
        row[0]: row[1:]
        for row in re.findall(r"^\| `(\w+)`.* \| ([\d,]+).*? \| ([\d,]+) \| (\d+) \|$", text, re.M)
    }
    assert rows == {
        each.name: (f"{each.batches * each.batch_steps:,}", f"{each.batch_steps:,}", f"{each.num_envs}")
        for each in BUDGETS.values()
    }
