"""Maps of 2-D navigation as SVG."""

from __future__ import annotations

from gym_extensions.catalog.sheets import Sheet

COLORS = {"wall": "#9a7b5b", "goal": "#c62828"}
"""Colors of a map in a file of its own, by class."""
SIZE = (640, 480)
"""Width and height of a map in units; y points down in pictures and up in coordinates."""


def map_elements(sheet: Sheet) -> str:
    """The obstacles and the goal of a map, as elements of a picture of this size."""
    obstacles = "".join(f"M{x} {y}h{width}v{height}h-{width}" for x, y, width, height in sheet.obstacles)
    x, y = sheet.goal or (0.0, 0.0)
    return f'<path class="wall" d="{obstacles}"/><circle class="goal" cx="{x:g}" cy="{y:g}" r="20"/>'


def map_file(sheet: Sheet) -> str:
    """The map as a file of its own, in fixed colors."""
    elements = map_elements(sheet)
    for name, color in COLORS.items():
        elements = elements.replace(f'class="{name}"', f'fill="{color}"')
    width, height = SIZE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}"><rect width="{width}" height="{height}" fill="#fff"/>{elements}</svg>\n'
    )
