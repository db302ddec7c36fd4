"""The version of fenics_mech, its one source."""

__version__ = "0.3.0.dev0"
