"""The loop: trains an agent through a protocol, evaluates it, records the log."""
