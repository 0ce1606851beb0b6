"""What the ``score`` command shows on terminals: colours, widths, numbers, and what strangers wrote."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.scoring import cli

Write = Callable[..., Path]


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """What the command prints about a folder with these variables of the environment."""

    def shown(folder: Path, **environment: str) -> str:
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        assert cli.main([str(folder)]) == 0
        return capsys.readouterr().out

    return shown


def test_colour_is_for_terminals_and_no_color_is_honoured(
    submission: Write, screen: Callable[..., str]
) -> None:
    folder = submission()
    assert "\x1b[" not in screen(folder)
    assert "\x1b[1m" in screen(folder, FORCE_COLOR="1", TERM="xterm-256color")
    assert "\x1b[3" not in screen(folder, NO_COLOR="1")


def test_what_strangers_write_is_shown_literally(
    submission: Write, manifest_text: str, screen: Callable[..., str]
) -> None:
    odd = ":rocket: [bold]x[/bold] [/] C:\\"
    folder = submission(manifest=manifest_text.replace("An entry", odd.replace("\\", "\\\\")))
    assert screen(folder).splitlines()[0] == f"entry  {odd}  (validated)"


def test_large_returns_are_told_in_thousands_at_80_columns(
    submission: Write, screen: Callable[..., str]
) -> None:
    def value(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
        return 1e5 * stage + 2e3 * episode + run if position == 2 else 9.0 + run

    shown = screen(submission(groups=("humanoid-standup-run",), value=value), COLUMNS="80")
    rows = [re.split(r"  +", line.rstrip()) for line in shown.splitlines()]
    # After the last stage 300000 + 19000 ± 11533, before any training 19000 ± 11533.
    found = next(row[1:] for row in rows if row[0] == "HumanoidStandup")
    assert found == ["319k ± 12k", "219k ± 12k", "119k ± 12k", "119k ± 12k"]


def test_output_is_readable_at_80_columns(submission: Write, screen: Callable[..., str]) -> None:
    shown = screen(submission(), COLUMNS="80")
    assert max(map(len, shown.splitlines())) <= 80


def test_a_terminal_that_knows_no_unicode_gets_no_traceback(submission: Write) -> None:
    code = "import sys; from gym_extensions.scoring.cli import main; sys.exit(main())"
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    command = [sys.executable, "-c", code, str(submission())]
    found = subprocess.run(command, env=environment, capture_output=True, check=False)
    assert (found.returncode, found.stderr) == (0, b"")
