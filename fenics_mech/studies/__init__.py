"""Studies: the program against its references, refinement, cost."""
