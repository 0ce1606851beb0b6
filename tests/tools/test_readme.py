"""tools/README.md lists the commands, and no other. Each says how it is used."""

import importlib
import re
import sys

import pytest

from tools import ROOT
from tools.benchmarks import measure_looks

COMMANDS = re.findall(r"python -m ([\w.]+)", (ROOT / "tools" / "README.md").read_text("utf-8"))


def test_the_readme_lists_every_command() -> None:
    modules = [path for path in (ROOT / "tools").rglob("*.py") if '"__main__"' in path.read_text("utf-8")]
    names = {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in modules}
    assert sorted(COMMANDS) == sorted(name.removesuffix(".__main__") for name in names)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_help(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if name == "tools.findings":
        pytest.importorskip("matplotlib", reason="the figures need matplotlib: the extra `plot`")
    module = importlib.import_module(name)
    module = importlib.import_module(f"{name}.__main__") if hasattr(module, "__path__") else module
    monkeypatch.setattr(sys, "argv", [name, "--help"])
    with pytest.raises(SystemExit, match="0"):
        module.main()
    assert capsys.readouterr().out.startswith(f"usage: python -m {name} ")


def test_a_table_that_does_not_exist_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert measure_looks.main(["errors", "cover"]) == 2
    assert "There is no table 'cover'. Did you mean 'coverage'?" in capsys.readouterr().err
