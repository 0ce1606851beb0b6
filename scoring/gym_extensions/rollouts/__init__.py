"""The format of a submission, with rollout logs, manifest and traces. Writes, reads and checks it."""
