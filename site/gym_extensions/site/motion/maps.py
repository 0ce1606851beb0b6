"""Maps of 2-D navigation as SVG."""

from __future__ import annotations

from gym_extensions.catalog.sheets import Sheet

WALL, GOAL = "#9a7b5b", "#c62828"
SIZE = (640, 480)
"""Width and height of a map in units; y points down in pictures and up in coordinates."""


def map_file(sheet: Sheet) -> str:
    """The map with its goal as an SVG file."""
    obstacles = "".join(f"M{x} {y}h{width}v{height}h-{width}" for x, y, width, height in sheet.obstacles)
    x, y = sheet.goal or (0.0, 0.0)
    width, height = SIZE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}"><rect width="{width}" height="{height}" fill="#fff"/>'
        f'<path d="{obstacles}" fill="{WALL}"/><circle cx="{x:g}" cy="{y:g}" r="20" fill="{GOAL}"/></svg>\n'
    )
