"""Charts as inline SVG: pure functions from numbers to markup. Colours come from the style sheet."""
