"""A report of a result as one page that needs nothing else."""

from fenics_mech.views.page.build import report

__all__ = ["report"]
