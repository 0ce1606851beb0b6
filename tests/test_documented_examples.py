"""A test runs the Python of each page of the documentation, and the options of each command exist."""

from __future__ import annotations

import argparse
import importlib.util
import re
import shlex
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from gym_extensions.__main__ import main
from gym_extensions.rollouts.reader import read

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), ROOT / "docs/environments/README.md"])
BLOCK = re.compile(r"^```(?P<language>\w*)\n(?P<code>.*?)^```", re.DOTALL | re.MULTILINE)
TESTS = {
    "README.md": "tests/test_readme.py",
    "docs/checkpoints.md": "tests/examples/test_checkpoints.py",
    "docs/custom-groups.md": "tests/test_custom_group.py",
    "docs/environments/README.md": "tests/envs/docgen/test_docgen.py",
    "docs/results.md": "tests/results/test_docs.py",
    "docs/submit.md": "tests/baselines/test_submit_doc.py",
}
"""The test module that runs the Python blocks of a page."""
NOT_OURS = {"git", "pre", "cd", "mkdocs"}
"""Programs of other projects, whose options are not checked."""
COMMAND = re.compile(r"(?:gym-extensions|score|make|pip|python|bash|git|cd) \S")


class ParsedError(Exception):
    """The options were parsed; nothing else of the command ran."""


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def blocks(page: Path, *languages: str) -> list[str]:
    text = page.read_text(encoding="utf-8")
    return [block["code"] for block in BLOCK.finditer(text) if block["language"] in languages]


def commands(page: Path) -> list[str]:
    """The lines of the blocks without a language that are commands."""
    lines = [
        line for code in blocks(page, "", "bash", "sh") for line in code.replace("\\\n", " ").splitlines()
    ]
    return [line for line in lines if COMMAND.match(line)]


COMMANDS = sorted({command for page in PAGES for command in commands(page)})


def module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = loaded  # dataclasses look their module up
    spec.loader.exec_module(loaded)
    return loaded


def program(words: list[str]) -> tuple[Callable[[list[str]], object], list[str]]:
    """The function behind a command line, and its arguments."""
    if words[0] == "python":
        return module(ROOT / words[1]).main, words[2:]
    return main, words[1:] if words[0] == "gym-extensions" else words


@pytest.mark.parametrize("page", PAGES, ids=relative)
def test_a_page_with_python_has_a_test_that_reads_it(page: Path) -> None:
    if not blocks(page, "python"):
        return
    test = (ROOT / TESTS[relative(page)]).read_text(encoding="utf-8")
    assert page.name in test
    assert re.search(r"\bexec\(|\bexecuted\(|subprocess|examples", test)


def test_there_are_commands_of_every_kind() -> None:
    assert len(COMMANDS) > 20
    assert {command.split()[0] for command in COMMANDS} >= {
        "gym-extensions",
        "score",
        "make",
        "pip",
        "python",
    }


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
        targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text("utf-8"), flags=re.MULTILINE)
        assert words[-1].startswith("VERSION=") or words[-1] in [*targets, "make"]
        return
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    named = [name for word in words for names in re.findall(r"\[(.*)\]", word) for name in names.split(",")]
    assert set(named) <= set(extras)
    files = [words[index + 1] for index, word in enumerate(words) if word == "-c"]
    assert all((ROOT / file).exists() for file in files)


def test_the_documented_manifest_breaks_no_rule(submission: Callable[..., Path]) -> None:
    (text,) = blocks(ROOT / "docs/rollout-log.md", "toml")
    text = text.replace('"https://…"', '"https://example.org/mine"').replace(
        'sha256 = "…"', f'sha256 = "{"0" * 64}"'
    )
    text, section, root = text.partition("[traces]")  # the made-up logs commit to no traces
    assert section and tomllib.loads(root).keys() == {"root"}
    assert read(submission(manifest=text)).problems == ()
