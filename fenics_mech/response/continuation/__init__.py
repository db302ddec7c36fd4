"""Branches of periodic motions over one number of a scene."""
