"""The format of a submission, with rollout logs, documents and policies. Writes, reads and checks it."""
