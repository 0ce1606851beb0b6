"""What readers take away from the page of an entry: commands, a citation, a badge and its metrics as CSV."""
