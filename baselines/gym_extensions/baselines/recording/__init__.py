"""Records policies that were trained elsewhere: evaluates them and writes the log that the loop writes."""
