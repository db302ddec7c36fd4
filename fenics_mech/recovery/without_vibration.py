"""Strains and stresses without vibration, to be seen beside those with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from fenics_mech.forces.element_loads import pin_loads
from fenics_mech.forces.section_forces import section_forces
from fenics_mech.forces.strains import stress_over_modulus, young_modulus
from fenics_mech.response.solution import Solution
from fenics_mech.response.static.quasi_static import solve_static


def without_vibration(solution: Solution) -> xr.Dataset:
    """Give the quasi-static strains and stresses of a motion in linear theory.

    The links bend under loads and the inertia of the rigid motion, and their own vibration is left out.

    Parameters
    ----------
    solution
        The response.

    Returns
    -------
    xarray.Dataset
        `strain_quasi_static` and `stress_quasi_static` (Pa) over theta, member, s and fibre.
    """
    scene, system = solution.scene, solution.system
    s = np.linspace(0, 1, scene.analysis.stations)
    linear = replace(system, terms=replace(system.without_axial_forces.terms, law=None, coupled=False))
    response = solve_static(linear)
    axial, _, moment = (
        force.reshape(len(force), -1, len(s))
        for force in section_forces(linear, response, s, pin_loads(linear, response))
    )
    sections = scene.rigidities(s)
    by_force, by_moment = stress_over_modulus(sections, axial, moment)
    strain = by_force[..., None] + by_moment  # (6.38)
    along = ("theta", "member", "s", "fibre")
    return xr.Dataset(
        {"strain_quasi_static": (along, strain), "stress_quasi_static": (along, young_modulus(sections) * strain)}
    )
