"""Digests of traces, their Merkle root, and the audit sample that a log and a salt select."""
