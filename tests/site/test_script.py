"""The script of the tables is small, and computes no statistic."""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
from pathlib import Path

import pytest

import gym_extensions.site

SCRIPT = Path(gym_extensions.site.__path__[0]) / "static" / "table.js"


def run(program: str) -> object:
    """What a program with the script's functions as ``t`` prints, read as JSON."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed; the browser tests run the script, too")
    text = f"const t = require({json.dumps(str(SCRIPT))}); console.log(JSON.stringify({program}))"
    return json.loads(subprocess.run([node, "-e", text], check=True, capture_output=True, text=True).stdout)


def test_the_script_has_less_than_twenty_kilobytes_compressed() -> None:
    assert len(gzip.compress(SCRIPT.read_bytes())) < 20_000


def test_a_difference_is_looked_up_in_both_directions() -> None:
    found = {
        "columns": ["final_performance"],
        "names": ["a", "b", "c"],
        "pairs": {"0,1": [[0.25, 0.125, 0.5, 0.01]], "0,2": [[0.25, None, None, None]], "1,2": [None]},
    }
    look_up = f"(one, two) => t.difference({json.dumps(found)}, one, two, 'final_performance')"
    results = run(f"[['a','b'],['b','a'],['c','a'],['b','c'],['a','x']].map((pair) => ({look_up})(...pair))")
    assert results == [
        {"v": 0.25, "low": 0.125, "high": 0.5, "p": 0.01},
        {"v": -0.25, "low": -0.5, "high": -0.125, "p": 0.01},
        {"v": -0.25, "low": None, "high": None, "p": None},
        None,
        None,
    ]


def test_the_functions_of_the_script() -> None:
    results = run(
        """{
        parsed: t.parsed("\\u22120.421 \\u00b10.113"),
        fixed: [t.fixed(-0.001), t.fixed(-1.5)],
        state: t.writeState(t.readState("#?q=a+b&sort=forgetting&up=1&level=verified&compare=x,y&hide=runs")),
        csv: t.csvText([{a: "=1,2", b: null, c: -1}]),
        }"""
    )
    assert isinstance(results, dict)
    assert results["parsed"] == {"v": -0.421, "h": 0.113}
    assert results["fixed"] == ["0.00", "\u22121.50"]
    assert results["state"] == "#?q=a+b&sort=forgetting&up=1&level=verified&hide=runs&compare=x%2Cy"
    assert results["csv"] == 'a,b,c\n"\'=1,2",,-1\n'
