"""Tables of results that were published without logs."""
