"""A report of a result as one page that needs nothing else."""
