"""Boards show the entries of one group side by side, with rank intervals."""
