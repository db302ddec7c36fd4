"""Scenes as input of other programs."""
