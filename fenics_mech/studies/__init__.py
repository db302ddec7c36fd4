"""Studies: many analyses of a scene and of its neighbours."""
