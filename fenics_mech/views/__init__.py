"""Pictures and words for people: plots, animation, tables, and a summary of a result."""

from fenics_mech.views.animation import animate, check_ending
from fenics_mech.views.effect_plots import plot_effects, runs_table
from fenics_mech.views.measured import read_measurement
from fenics_mech.views.plots import plot_all, plot_frequencies, plot_strain
from fenics_mech.views.report import summary
from fenics_mech.views.tables import check_table, effects_table, frequency_table, scene_overview, write_frequencies

__all__ = [
    "animate",
    "check_ending",
    "check_table",
    "effects_table",
    "frequency_table",
    "plot_all",
    "plot_effects",
    "plot_frequencies",
    "plot_strain",
    "read_measurement",
    "runs_table",
    "scene_overview",
    "summary",
    "write_frequencies",
]
