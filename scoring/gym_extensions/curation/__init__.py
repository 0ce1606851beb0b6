"""Decides which submissions are on the boards: the ledger, challenges, and the gate for pull requests."""
