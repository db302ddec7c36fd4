"""The version of fenics_mech, its one source."""

__version__ = "0.2.0"
