"""Response in time from a given state."""
