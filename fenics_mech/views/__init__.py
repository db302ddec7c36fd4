"""Pictures and words for people: plots, animation, tables, and a summary of a result."""
