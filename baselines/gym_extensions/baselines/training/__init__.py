"""The training loop: runs any agent through a protocol, evaluates it and records every episode."""
