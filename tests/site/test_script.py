"""The scripts of the tables and of Compare are small, and compute no statistic."""

import gzip
import json
import shutil
import subprocess
from pathlib import Path

import pytest

import gym_extensions.site

SCRIPT = Path(gym_extensions.site.__path__[0]) / "static" / "table.js"


def run(program: str, script: str = "table.js") -> object:
    """What a program with a script's functions as ``t`` prints, read as JSON."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed; the browser tests run the script, too")
    path = json.dumps(str(SCRIPT.with_name(script)))
    text = f"const t = require({path}); console.log(JSON.stringify({program}))"
    return json.loads(subprocess.run([node, "-e", text], check=True, capture_output=True, text=True).stdout)


def test_the_scripts_have_less_than_25_kilobytes_compressed() -> None:
    static = SCRIPT.parent
    assert sum(len(gzip.compress(path.read_bytes())) for path in static.glob("*.js")) < 25_000


@pytest.mark.parametrize(
    ("pair", "difference"),
    [
        (("a", "b"), [0.25, 0.125, 0.5]),
        (("b", "a"), [-0.25, -0.5, -0.125]),
        (("c", "a"), [-0.25, None, None]),
        (("b", "c"), None),
        (("a", "x"), None),
    ],
)
def test_a_difference_is_looked_up_in_both_directions(
    pair: tuple[str, str], difference: list[float | None] | None
) -> None:
    found = {
        "names": ["a", "b", "c"],
        "pairs": {"0,1": [[0.25, 0.125, 0.5]], "0,2": [[0.25, None, None]], "1,2": [None]},
    }
    assert run(f"t.difference({json.dumps(found)}, ...{json.dumps(pair)})", "compare.js") == difference


def test_the_answer_over_the_core_is_the_first_minus_the_second() -> None:
    pairs = [["a", "b", 0.2, 0.1, 0.3, 0.01, "separated", 5, True]]
    answer = run(f"t.verdict({json.dumps(pairs)}, 'b', 'a')", "compare.js")
    assert answer == {
        **{"mean": -0.2, "low": -0.3, "high": -0.1, "p": 0.01},
        **{"verdict": "separated", "runs": 5, "preliminary": True},
    }


def test_a_small_negative_number_has_no_sign() -> None:
    assert run("[t.fixed(-0.001), t.fixed(-1.5)]", "compare.js") == ["0.00", "\u22121.50"]


def test_the_functions_of_the_script() -> None:
    results = run(
        """{
        parsed: t.parsed("\\u22120.421 \\u00b10.113"),
        none: t.parsed("\\u2013"),
        state: t.writeState(t.readState("#?q=a+b&sort=forgetting&up=1&level=verified&compare=x,y&hide=runs")),
        }"""
    )
    assert isinstance(results, dict)
    assert results["parsed"] == {"v": -0.421}
    assert results["none"] == {"v": None}
    assert results["state"] == "#?q=a+b&sort=forgetting&up=1&level=verified&hide=runs&compare=x%2Cy"


def test_rows_without_a_value_are_last_in_both_directions() -> None:
    rows = [{"order": at, "values": {"kept": value}} for at, value in enumerate((0.2, None, 0.5))]
    for up, order in ((False, [2, 0, 1]), (True, [0, 2, 1])):
        found = run(
            f"t.sorted({json.dumps(rows)}, 'kept', {json.dumps(up)}).map((r) => r.order)", "methods.js"
        )
        assert found == order


def test_a_mean_over_groups_needs_all_of_them() -> None:
    assert run("[t.meanAt([1, 3, null], [0, 1]), t.meanAt([1, 3, null], [1, 2])]", "methods.js") == [2, None]


def test_the_address_of_the_table_is_read_as_it_was_written() -> None:
    text = "#?cells=learned&list=1&groups=hopper-wall&sort=g2&up=1&compare=a%2Cb&all=1"
    assert run(f"t.write(t.read({json.dumps(text)}))", "methods.js") == text
