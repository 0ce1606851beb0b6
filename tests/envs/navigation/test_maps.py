"""The ten maps and their thirty goals, as files and as the generator draws them."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys

import numpy as np
import pytest

from gym_extensions.envs.navigation import generate_maps as draw_maps
from gym_extensions.envs.navigation.geometry import (
    draw,
    goals,
    load,
    map_bytes,
    parse,
)

MAPS = range(10)


@pytest.mark.parametrize("number", MAPS)
def test_a_map_is_48_lines_of_64_with_a_solid_border(number: int) -> None:
    lines = map_bytes(number).decode("ascii").split("\n")
    assert lines.pop() == ""
    assert len(lines) == 48
    assert {len(line) for line in lines} == {64}
    assert set("".join(lines)) == {"#", "."}
    assert set(lines[0] + lines[-1]) == {"#"}
    assert {line[0] + line[-1] for line in lines} == {"##"}


@pytest.mark.parametrize("number", MAPS)
def test_free_space_is_one_region_joined_by_edges(number: int) -> None:
    cells = load(number).cells
    free = {(int(row), int(column)) for row, column in np.argwhere(~cells)}
    seen, frontier = set(), [next(iter(sorted(free)))]
    while frontier:
        row, column = frontier.pop()
        if (row, column) in free and (row, column) not in seen:
            seen.add((row, column))
            frontier += [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
    assert seen == free
    # Rectangles cover a tenth to a fifth of a map, and the border 7 %.
    assert 0.15 < cells.mean() < 0.30


@pytest.mark.parametrize("number", MAPS)
def test_goals_are_cell_centres_clear_of_obstacles_and_apart(number: int) -> None:
    centres = [goals()[number, goal] for goal in range(3)]
    for x, y in centres:
        assert (x % 10, y % 10) == (5, 5)
        for row, column in np.argwhere(load(number).cells):
            gap_x, gap_y = max(abs(10 * column + 5 - x) - 5, 0), max(abs(10 * row + 5 - y) - 5, 0)
            assert math.hypot(gap_x, gap_y) >= 20
    assert all(math.dist(*pair) >= 150 for pair in itertools.combinations(centres, 2))


def test_there_are_thirty_goals_and_all_maps_differ() -> None:
    assert sorted(goals()) == [(number, goal) for number in MAPS for goal in range(3)]
    assert len({map_bytes(number) for number in MAPS}) == 10


def test_the_first_line_of_a_map_is_its_top() -> None:
    grid = parse(["####", "#.##", "#..#", "####"])
    assert grid.cells[1].tolist() == [True, False, False, True]
    assert grid.cells[2].tolist() == [True, False, True, True]
    assert draw(grid.cells) == "####\n#.##\n#..#\n####\n"


@pytest.mark.parametrize("lines", [[], ["##", "#"], ["#x"]])
def test_a_map_of_another_shape_or_character_raises_an_error(lines: list[str]) -> None:
    with pytest.raises(ValueError, match="a map is lines of equal length"):
        parse(lines)


def test_the_committed_files_are_what_the_rule_draws() -> None:
    assert draw_maps.main(["--check"]) == 0


def test_importing_the_environments_and_a_gravity_task_loads_no_compiler() -> None:
    code = (
        "import sys, gym_extensions.envs as envs, gymnasium as gym\n"
        "gym.make('gym_extensions/HopperGravityHalf-v0').reset(seed=0)\n"
        "envs.group('nav-range').tasks\n"
        "raise SystemExit('numba' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
