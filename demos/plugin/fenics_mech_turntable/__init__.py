"""What this package adds to fenics_mech: see `pyproject.toml`."""
