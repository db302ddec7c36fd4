"""Pictures and words for linkages in space: summary, plots, report, animation, and the drawing of a model."""
