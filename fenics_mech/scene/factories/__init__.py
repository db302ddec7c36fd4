"""Scenes of common machines, from their dimensions. Here, and only here, a machine is special."""

from fenics_mech.scene.factories.four_bar import four_bar, seed_four_bar
from fenics_mech.scene.factories.manipulator import manipulator
from fenics_mech.scene.factories.quick_return import quick_return
from fenics_mech.scene.factories.slider_crank import slider_crank

__all__ = ["four_bar", "manipulator", "quick_return", "seed_four_bar", "slider_crank"]
