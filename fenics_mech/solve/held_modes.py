"""Modes of a machine that is held at its positions, and their damping."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.optimize import linear_sum_assignment

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.machine import Machine
from fenics_mech.terms import ModalDamping

POSITIONS = 36  # of a cycle, at which modes are damped
ROUNDING = float(np.finfo(float).eps)


def held_modes(machine: Machine, t: float) -> tuple[Array, Array]:
    """Give the frequencies (rad/s) of a machine held at the place of its chart, and shapes of unit stiffness.

    Parameters
    ----------
    machine
        The machine, without damping of modes.
    t
        Instant (s).

    Returns
    -------
    tuple
        ``(modes,)``, the slowest first, and ``(size, modes)``.

    Raises
    ------
    SolverError
        When drives and joints leave something free to move, or nothing at all.
    """
    return next(_each_held(machine, np.array([t])))[:2]


def _each_held(machine: Machine, times: Array) -> Iterator[tuple[Array, Array, Array]]:
    """Give what `held_modes` gives at each of some instants, and the mass ``(coordinates, coordinates)``."""
    n, zero = machine.n, np.zeros((len(times), machine.size))
    found = machine.residual(times, zero, zero, zero, moving=False)
    for t, M, K in zip(times, machine.pattern.dense(found.M), machine.pattern.dense(found.K)):
        yield *_held(machine, float(t), M, K), M[:n, :n]


def _held(machine: Machine, t: float, M: Array, K: Array) -> tuple[Array, Array]:
    """Give frequencies and shapes by the tangents of an instant (s), ``(size, size)`` each."""
    n = machine.n
    free = scipy.linalg.null_space(K[n:, :n], rcond=1e-10) if machine.held else np.eye(n)
    mass, stiffness, what = (
        free.T @ M[:n, :n] @ free,
        free.T @ K[:n, :n] @ free,
        f"modes of the machine held at {t:.6g} s",
    )
    if not len(stiffness):
        raise SolverError(f"{what}: there are none, as its joints and drives leave no coordinate free")
    try:
        squares, shapes = scipy.linalg.eigh(mass, stiffness)
        slowest = np.abs(shapes[:, -1])
        strained = len(slowest) * ROUNDING * (slowest @ np.abs(stiffness) @ slowest) < 1.0  # its stiffness
    except np.linalg.LinAlgError:  # the stiffness is not positive
        strained = False
    if not strained:
        raise SolverError(
            f"{what}: something is free to move without strain, or unstable. Hold it by drives or joints, or take "
            "frequencies(), which gives rigid motions too"
        )
    whole = np.zeros((machine.size, len(squares)))
    whole[:n] = free @ shapes
    return 1 / np.sqrt(np.maximum(squares[::-1], 1e-300)), whole[:, ::-1]


@dataclass(frozen=True)
class FollowedModes:
    """Modes of a machine that is held at positions, each after the one that is most alike.

    Parameters
    ----------
    omega
        Frequencies ``(positions, modes)`` (rad/s).
    shapes
        Of unit mass ``(positions, coordinates, modes)``.
    momenta
        The mass times them.
    """

    omega: Array
    shapes: Array
    momenta: Array

    @property
    def assurance(self) -> Array:
        """How far each mode is that of the next position, 0..1 ``(positions, modes)``; the last: which it is most."""
        back = np.einsum("knm,knl->kml", self.momenta, np.roll(self.shapes, -1, axis=0)) ** 2
        found = np.einsum("kmm->km", back).copy()
        found[-1] = back[-1].max(axis=0)
        return found


def followed_modes(machine: Machine, times: Array) -> FollowedModes:
    """Give the modes of a machine held at the places of its chart, followed from one instant to the next.

    Parameters
    ----------
    machine
        The machine, without damping of modes.
    times
        Instants ``(positions,)`` (s).
    """
    omegas: list[Array] = []
    shapes: list[Array] = []
    momenta: list[Array] = []
    for held, stiff, mass in _each_held(machine, times):
        omega, shape = held, held * stiff[: machine.n]
        momentum = mass @ shape
        if shapes:
            alike = shapes[-1].T @ momentum
            order = linear_sum_assignment(-np.abs(alike))[1]
            signs = np.where(alike[np.arange(len(order)), order] < 0, -1.0, 1.0)
            omega, shape, momentum = omega[order], shape[:, order] * signs, momentum[:, order] * signs
        omegas.append(omega)
        shapes.append(shape)
        momenta.append(momentum)
    return FollowedModes(np.array(omegas), np.array(shapes), np.array(momenta))


def damp_modes(
    machine: Machine,
    period: float,
    ratio: float | Sequence[float],
    *,
    fastest: float = 32.0,
    positions: int = POSITIONS,
    times: Array | None = None,
) -> None:
    """Damp the slow modes of a machine by their ratios, in a cycle of its chart.

    Parameters
    ----------
    machine
        The machine; its chart is the cycle.
    period
        s.
    ratio
        Damping ratio of all modes, or of the slowest ones; the last holds for the rest.
    fastest
        Frequency below which modes are damped, over that of the slowest mode of the cycle. Faster ones follow their
        loads. Strains of slender members of five demos need 8 to be within 2e-5 of those with all modes, and those of a
        stiff crank 32 to be within 4e-5.
    positions
        Even positions of the cycle at which the modes are found: with 24 instead of 48 they are within 2e-5.
    times
        Instants at which the chart is at these positions; None for even ones from 0 (s).
    """
    times = period / positions * np.arange(positions) if times is None else times
    strains, lags = _damped(machine, times, ratio, fastest)
    machine.beams.modal = ModalDamping.of(machine.beams.stiffness, strains, lags, period)
    machine.forget_plan()


def held_damping(machine: Machine, t: float, ratio: float | Sequence[float]) -> Array:
    """Give the stress of all modes of a machine held at the place of its chart: E as of `HeldDamping`.

    Parameters
    ----------
    machine
        The machine, without damping of modes.
    t
        Instant (s).
    ratio
        As of `damp_modes`.

    Returns
    -------
    ndarray
        ``(elements, strains, modes)``.
    """
    (strain,), (lag,) = _damped(machine, np.array([t]), ratio, np.inf)
    return np.asarray(np.einsum("eij,ejk->eik", machine.beams.stiffness, strain) * np.sqrt(lag))


def _damped(
    machine: Machine, times: Array, ratio: float | Sequence[float], fastest: float
) -> tuple[list[Array], list[Array]]:
    """Give strains of the slow modes of unit energy at instants, and ``2 zeta/omega`` of each (s)."""
    term = machine.terms.index(machine.beams)
    group = machine.groups[term]
    modes = [(omega, shape) for omega, shape, _ in _each_held(machine, times)]
    zero = np.zeros((len(times), machine.size))
    measured = machine.residual(times, zero, zero, zero, moving=False, tangents=False).terms[term]
    most = fastest * min(omega[0] for omega, _ in modes)
    stated = np.atleast_1d(ratio)
    strains, lags = [], []
    for k, (omega, shapes) in enumerate(modes):
        slow = omega < most
        inside = np.clip(3 * (1 - omega[slow] / most), 0.0, 1.0)
        ratios = stated[np.minimum(np.arange(slow.sum()), len(stated) - 1)] * inside**2 * (3 - 2 * inside)
        strains.append(np.einsum("emn,ken->emk", measured.gradient[k], group.variables(shapes[:, slow].T)))
        lags.append(2 * ratios / omega[slow])
    return strains, lags
