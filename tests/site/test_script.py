"""The scripts are small, and Compare looks its differences up; tests in a browser run the rest."""

import gzip
import json
import shutil
import subprocess
from pathlib import Path

import pytest

import gym_extensions.site

STATIC = Path(gym_extensions.site.__path__[0]) / "static"


def run(program: str, script: str) -> object:
    """What a program with a script's functions as ``t`` prints, read as JSON."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed; the browser tests run the script, too")
    shared, own = (f"require({json.dumps(str(STATIC / name))})" for name in ("page.js", script))
    text = f"{shared}; const t = {own}; console.log(JSON.stringify({program}))"
    return json.loads(subprocess.run([node, "-e", text], check=True, capture_output=True, text=True).stdout)


def test_the_scripts_have_less_than_25_kilobytes_compressed() -> None:
    assert sum(len(gzip.compress(path.read_bytes())) for path in STATIC.glob("*.js")) < 25_000


def test_differences_are_looked_up_in_both_directions() -> None:
    found = {
        "names": ["a", "b", "c"],
        "pairs": {"0,1": [[0.25, 0.125, 0.5]], "0,2": [[0.25, None, None]], "1,2": [None]},
    }
    differences = {
        **{"ab": [0.25, 0.125, 0.5], "ba": [-0.25, -0.5, -0.125], "ca": [-0.25, None, None]},
        **{"bc": None, "ax": None},
    }
    program = f"{json.dumps(list(differences))}.map((pair) => t.difference({json.dumps(found)}, ...pair))"
    assert run(program, "compare.js") == list(differences.values())


def test_numbers_and_means_over_groups() -> None:
    assert run("[page.fixed(-0.001), page.fixed(-1.5)]", "page.js") == ["0.00", "\u22121.50"]
    numbers = "['\\u22120.421 \\u00b10.113', '1\\u202f000', '\\u2013'].map(page.number)"
    assert run(numbers, "page.js") == [-0.421, 1000, None]
    assert run("[t.meanAt([1, 3, null], [0, 1]), t.meanAt([1, 3, null], [1, 2])]", "methods.js") == [2, None]
