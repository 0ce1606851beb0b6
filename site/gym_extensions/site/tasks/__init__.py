"""What the page of a task shows: what differs from its base body, references and best entries."""
