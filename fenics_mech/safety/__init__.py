"""Is the machine safe? Factors of safety of its members by every way in which they may fail, and what would help."""
