"""The version of fenics_mech, its one source."""

__version__ = "0.1.0"
