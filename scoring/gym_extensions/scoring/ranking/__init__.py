"""Submissions side by side: boards and comparisons, copies, and rows that follow from the references."""
