"""The Watch panel: audited episodes drawn as stroboscopes, and handed to the player of the browser."""
