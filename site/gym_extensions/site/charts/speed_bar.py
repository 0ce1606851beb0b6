"""A measured speed as a bar."""

from __future__ import annotations

from markupsafe import Markup

from gym_extensions.site.views.benchmarks import Variant

WIDTH, HEIGHT = 220, 12


def speed_bar(variant: Variant) -> Markup:
    """The speed as a bar, on the scale of the fastest variant of the comparison."""
    kind = "own" if variant.ratio is None else "other"
    return Markup(
        f'<svg class="speed" viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">'
        f'<rect class="{kind}" width="{variant.share * WIDTH:.1f}" height="{HEIGHT}"/></svg>'
    )
