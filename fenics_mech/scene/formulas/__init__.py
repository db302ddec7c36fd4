"""Formulas in a scene: expressions of the drive angle, and intervals that bound them."""
