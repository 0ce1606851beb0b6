"""The format of a submission: rollout logs, manifest, traces. Writes, reads and checks it."""
