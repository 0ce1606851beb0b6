"""Decides which submissions are on the boards: the gate for pull requests, reviews and decisions."""
