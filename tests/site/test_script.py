"""The script of the tables is small, and its arithmetic is that of the scorer."""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
from pathlib import Path

import pytest

import gym_extensions.site
from gym_extensions.scoring.statistics.intervals import difference, interval
from gym_extensions.scoring.statistics.student_t import quantile

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


def test_the_functions_of_the_script() -> None:
    a, b = [0.9, 0.8, 1.0, 0.95, 0.85], [0.5, 0.2, 0.7, 0.6, 0.3]
    sides = [
        {"v": side.mean, "h": side.mean - side.low, "runs": 5}
        for side in (interval(a), interval(b))
        if side.low is not None
    ]
    results = run(
        f"""{{
        quantiles: [1, 4, 7.5, 300].map(t.quantile),
        difference: t.difference({json.dumps(sides[0])}, {json.dumps(sides[1])}),
        single: t.difference({{v: 1, h: null, runs: 1}}, {{v: 2, h: 0.1, runs: 5}}),
        parsed: t.parsed("\\u22120.421 \\u00b10.113"),
        fixed: [t.fixed(-0.001), t.fixed(-1.5)],
        state: t.writeState(t.readState("#?q=a+b&sort=forgetting&up=1&trust=checked&compare=x,y&hide=runs")),
        csv: t.csvText([{{a: "=1,2", b: null, c: -1}}]),
        }}"""
    )
    assert isinstance(results, dict)
    assert results["quantiles"] == pytest.approx([quantile(0.975, df) for df in (1, 4, 7.5, 300)], rel=1e-6)
    exact = difference(a, b)
    assert exact.low is not None
    assert results["difference"] == pytest.approx({"v": exact.mean, "h": exact.mean - exact.low})
    assert results["single"] == {"v": -1, "h": None}
    assert results["parsed"] == {"v": -0.421, "h": 0.113}
    assert results["fixed"] == ["0.00", "\u22121.50"]
    assert results["state"] == "#?q=a+b&sort=forgetting&up=1&trust=checked&hide=runs&compare=x%2Cy"
    assert results["csv"] == 'a,b,c\n"\'=1,2",,-1\n'
