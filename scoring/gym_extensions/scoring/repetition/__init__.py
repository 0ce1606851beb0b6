"""Repeats all logged episodes with the stored policies, and compares them bit by bit."""
