"""Entries side by side: copies, the core board, and rows that follow from the references."""
