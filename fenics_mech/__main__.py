"""``python -m fenics_mech``."""

from fenics_mech.cli import main

main()
