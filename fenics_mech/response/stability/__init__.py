"""Whether small disturbances of a periodic motion decay."""
