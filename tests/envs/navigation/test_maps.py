"""The ten maps and their thirty goals have the properties of the rule that drew them."""

import itertools
import math

import numpy as np
import pytest
from scipy import ndimage

from gym_extensions.envs.navigation.geometry import goals, load, parse


@pytest.mark.parametrize("number", range(10))
def test_a_map_has_a_solid_border_and_one_free_region_with_goals_clear_of_obstacles(number: int) -> None:
    cells = load(number).cells
    assert cells.shape == (48, 64)
    assert cells[[0, -1]].all() and cells[:, [0, -1]].all()
    assert ndimage.label(~cells)[1] == 1, "joined by edges"
    # Rectangles cover a tenth to a fifth of a map, and the border 7 %.
    assert 0.15 < cells.mean() < 0.30
    centers = [goals()[number, goal] for goal in range(3)]
    for x, y in centers:
        assert (x % 10, y % 10) == (5, 5)
        for row, column in np.argwhere(cells):
            gap_x, gap_y = max(abs(10 * column + 5 - x) - 5, 0), max(abs(10 * row + 5 - y) - 5, 0)
            assert math.hypot(gap_x, gap_y) >= 20
    assert all(math.dist(*pair) >= 150 for pair in itertools.combinations(centers, 2))


def test_the_first_line_of_a_map_is_its_top() -> None:
    grid = parse(["####", "#.##", "#..#", "####"])
    assert grid.cells[1].tolist() == [True, False, False, True]
    assert grid.cells[2].tolist() == [True, False, True, True]
