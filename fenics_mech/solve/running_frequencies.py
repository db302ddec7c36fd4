"""Natural frequencies about a running motion: with spin, and with the forces of loads and of the rigid motion.

Beside the chart a machine moves by ``M x'' + C x' + K x + G^T l = 0, G x = 0``. All matrices change with the position.
The frequencies at a position are sought in axes that go with the links. There ``x = Z y``, whose columns change as
little, in the axes of their links, as the rows let them:

    ``M Z' + G^T L = N Z,   G Z' = -G' Z``,

where N is the mass between x and the velocity at which the links turn it. With ``Z^T M Z' = Z^T N Z`` at all times,

    ``y'' + Z^T (2 M Z' + C Z) y' + [Z^T (K Z + C Z') + Z'^T N Z + Z^T N' Z + Z^T N Z' - Z'^T M Z' - Z^T M' Z'] y = 0``.

Source: Genta, Dynamics of Rotating Systems (2005), ch. 2, for coordinates that turn with a body.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.optimize import linear_sum_assignment
from scipy.sparse.linalg import splu

from fenics_mech._arrays import Array
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.compiled_steps import mass_with_rows
from fenics_mech.solve.held_modes import DENSE, About, FollowedModes
from fenics_mech.solve.linear import axial_forces, quasi_static

MOST = 30  # modes that are looked at, the lowest: the time goes with the third power, and high ones change little
BESIDE = 12  # modes beside these in which motions are sought
SPACING = 1e-4  # rad of the fastest link, by which matrices are differentiated: its square, and rounding over it


def forces_about(machine: Machine, times: Array, moving: bool = True) -> About:
    """Give axial forces and multipliers of the static answer to loads, and to the inertia of the chart's motion.

    Parameters
    ----------
    machine
        The machine.
    times
        Instants (s).
    moving
        Whether that inertia acts.
    """
    still = quasi_static(machine, times, moving)
    pulls = np.where(np.arange(machine.size) < machine.n, 0.0, still.change[2])
    return About(axial_forces(machine, still), pulls)


def about_motion(
    machine: Machine, times: Array, held: FollowedModes, moving: bool = True, count: int | None = None
) -> Array:
    """Give the frequencies about the loaded motion ``(positions, modes)`` (rad/s), in the order of the held modes.

    Where a disturbance diverges instead of vibrating, its frequency is 0. Beyond the lowest `MOST` modes they are those
    held.

    Parameters
    ----------
    machine
        The machine, without damping; its chart is the rigid motion.
    times
        Instants of the positions (s).
    held
        Its modes there, held; those that are asked for and `BESIDE` more.
    moving
        Whether the chart moves; else loads alone act.
    count
        How many of the held modes are wanted, the first; None for all.
    """
    n, kept, zero = machine.n, machine.n + machine.held, np.zeros((len(times), machine.size))
    about = forces_about(machine, times, moving)
    loaded = machine.residual(times, zero, zero, about.pulls, predicted=about.stresses, moving=moving)
    masses, none = mass_with_rows(machine, loaded), np.zeros_like(loaded.M)
    N = M1 = N1 = G1 = none
    if moving:
        step = SPACING / max(1e-300, float(np.abs(machine.known.at(times).w).max()))
        ahead, here, behind = (machine.residual(times + by, zero, zero, zero) for by in (step, 0.0, -step))
        M1, G1 = (ahead.M - behind.M) / (2 * step), (ahead.K - behind.K) / (2 * step)
        N, N1 = _turned(machine, here), (_turned(machine, ahead) - _turned(machine, behind)) / (2 * step)
    found, few = held.omega.copy(), n <= DENSE
    whole = machine.pattern.dense if few else machine.pattern.matrix
    for k, omega in enumerate(held.omega):
        looked_at = min(MOST, 1 + int(np.argsort(np.argsort(omega))[:count].max()))
        M, C, K, dM, dG, T, dT = (whole(x[k]) for x in (loaded.M, loaded.C, loaded.K, M1, G1, N, N1))
        M, C, K, dM, T, dT = (x[:n, :n] for x in (M, C, K, dM, T, dT))
        lowest = np.argsort(omega)[: looked_at + BESIDE]
        Z, likeness = held.shapes[k][:, lowest], held.momenta[k][:, lowest[:looked_at]].T @ held.shapes[k][:, lowest]
        Z1 = np.zeros_like(Z)
        if moving:
            push = np.vstack([T @ Z, -(dG[n:kept, :n] @ Z)])
            matrix = whole(masses[k])[:kept, :kept]
            Z1 = (np.linalg.solve(matrix, push) if few else splu(sp.csc_matrix(matrix)).solve(push))[:n]
        damping = Z.T @ (2 * (M @ Z1) + C @ Z)
        stiffness = Z.T @ (K @ Z + C @ Z1) + Z1.T @ (T @ Z) + Z.T @ (dT @ Z + T @ Z1)
        stiffness -= Z1.T @ (M @ Z1) + Z.T @ (dM @ Z1)
        size = len(stiffness)
        state = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])
        values, vectors = scipy.linalg.eig(state)
        share = np.abs(likeness @ vectors[:size]) ** 2 / np.sum(np.abs(vectors[:size]) ** 2, axis=0)
        modes, places = linear_sum_assignment(-share * (values.imag >= 0))
        found[k, lowest[modes]] = values.imag[places]
    return found


def _turned(machine: Machine, here: Evaluation) -> Array:
    """Give the mass between coordinates and the velocities at which links turn them ``(instants, entries)`` (kg/s)."""
    # It is how a drag against the velocity beside the links' axes changes with the coordinates; `here` is without it.
    dragged, zero = copy(machine), np.zeros((len(here.t), machine.size))
    dragged.drag = replace(machine.drag, relative=machine.drag.relative + 1.0)
    return here.K - dragged.residual(here.t, zero, zero, zero).K
