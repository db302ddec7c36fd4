"""Periodic response by sub-intervals with constant coefficients (chapter 5, appendices E and F).

Sub-interval k is centred at drive angle theta_k, where M, K and the modes are taken. Inside it each mode is an
oscillator with an exact answer. The sub-intervals are joined, and the last one with the first, in one block-cyclic
linear system for the states at their starts, (5.16).

Damping goes with the rate of strain, ``q' + (P^T k P)^-1 P^T k P' q``. The second part acts as impulses at the joins.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, times
from fenics_mech._constants import TINY
from fenics_mech._guard import require_memory
from fenics_mech.effects import NOTHING
from fenics_mech.eigenmodes import Modes
from fenics_mech.errors import UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse, ModalDamping
from fenics_mech.mechanism import System
from fenics_mech.response.modal_damping import damping_ratios
from fenics_mech.response.periodic.cyclic import BlockCyclic
from fenics_mech.response.periodic.oscillator import Oscillators
from fenics_mech.response.stability.resonance import blaming, magnification, of_modes, refuse_magnified
from fenics_mech.response.static.quasi_static import displacement_under, solve_static
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class SubIntervalLimits:
    """Limits of the response by sub-intervals."""

    joined: int = 24  # matrices over the modes of a sub-interval that are held at a time: measured
    largest_ringing: float = 0.02  # of the square root of the largest strain energy
    most_advised: int = 1000  # sub-intervals: beyond, other ways cost less


SUB_INTERVALS = SubIntervalLimits()


def solve_sub_intervals(
    scene: Scene, system: System, modes: Modes, boundary_load: Array | None = None
) -> tuple[ElasticResponse, SubIntervals, float]:
    """Solve for the steady state of the truncated equation (5.1) with modal damping.

    Parameters
    ----------
    scene
        States damping, load and static correction.
    system
        The mechanism at the middles theta_k of the sub-intervals.
    modes
        The modes at the middles.
    boundary_load
        Load at the sub-intervals' starts (N, N m), ``(angles, coordinates)``, where the modal load is to be linear in
        them.

    Returns
    -------
    tuple
        The response at the middles, the sub-intervals as they are joined, and the condition of their system.

    Raises
    ------
    SolverError
        When the KSP does not converge or its answer is not accurate, as at an undamped resonance.
    UnresolvedError
        When modes ring that the sub-intervals are too long for.
    """
    joined, step = SubIntervals.of(scene, modes, straining(system, modes)), scene.period / len(modes.theta)
    load = np.einsum("kmi,ki->km", modes.shapes, system.load)  # (E.6)
    slope = np.zeros_like(load)
    if boundary_load is not None:
        rise = np.roll(boundary_load, -1, axis=0) - boundary_load
        slope = np.einsum("kmi,ki->km", modes.shapes, rise) / step
    starts = joined.starts(load, slope)
    condition = magnification(joined.cycle, starts)
    refuse_magnified(condition, joined.blame)
    state = joined.middles(starts, load, slope)
    if not scene.analysis.allow_ringing:
        free = state - joined.oscillators.particular(load - slope * step / 2, slope, step / 2)
        _refuse_ringing(scene.period, modes, state, free)
    return superpose(system, modes, state[..., 0], joined.viscous(state), load, scene), joined, condition


@dataclass(frozen=True)
class SubIntervals:
    """Modes in sub-intervals, joined to a cycle.

    Parameters
    ----------
    oscillators
        The modes, ``(sub-intervals, modes)``.
    duration
        Of the sub-intervals (s), ``(sub-intervals, 1)``.
    join, kick
        From y and y' at the end of each to those at the start of the next, ``(sub-intervals, modes, modes)``: y goes by
        the first; y' by the first, and from y by the second. See `_joins`.
    straining
        As `straining` gives it; 0 where the joins do not turn the modes.
    options
        PETSc options with the prefix "periodic_".
    """

    oscillators: Oscillators
    duration: Array
    join: Array
    kick: Array
    straining: Array
    options: Mapping[str, Any]

    @classmethod
    def of(cls, scene: Scene, modes: Modes, straining: Array, duration: Array | None = None) -> SubIntervals:
        """Join modes as the scene asks for.

        Parameters
        ----------
        scene
            The scene.
        modes
            Modes at the middles of the sub-intervals.
        straining
            As `straining` gives it.
        duration
            Of the sub-intervals (s), ``(sub-intervals,)``; by default equal parts of the cycle.
        """
        if duration is None:
            duration = np.full(len(modes.theta), scene.period / len(modes.theta))
        how, zeta, step = scene.analysis.join, damping_ratios(scene.damping.ratio, modes.omega), duration[:, None, None]
        straining = np.zeros_like(straining) if how == "modal" else straining  # there no mode turns
        drag = step / 2 * (2 * zeta * modes.omega)[..., None] * straining
        joins = _joins(how, modes, step, drag)
        return cls(Oscillators(modes.omega, zeta), duration[:, None], *joins, straining, scene.petsc)

    @cached_property
    def transitions(self) -> Array:
        """From the states at the start of each sub-interval to those at the start of the next."""
        count, m = self.oscillators.omega.shape
        free, omega = self.oscillators.transition(self.duration)[:, None], self.oscillators.omega
        transitions = np.empty((count, 2, m, 2, m))
        ahead = self.join * omega[:, None, :]
        for part in (0, 1):  # of y, and of y' over omega, at the start
            transitions[:, 0, :, part] = self.join * free[..., 0, part]
            transitions[:, 1, :, part] = ahead * free[..., 1, part]
            transitions[:, 1, :, part] += self.kick * free[..., 0, part]
        transitions[:, 1] /= np.roll(omega, -1, axis=0)[:, :, None, None]
        return transitions.reshape(count, 2 * m, 2 * m)

    def _carried(self, states: Array) -> Array:
        """From states ``(sub-intervals, modes, 2)`` at the ends to those at the next starts, flat."""
        y, rate = states[..., 0], states[..., 1] * self.oscillators.omega
        ahead = times(self.join, rate) + times(self.kick, y)
        return np.concatenate([times(self.join, y), ahead / np.roll(self.oscillators.omega, -1, axis=0)], axis=1)

    @cached_property
    def cycle(self) -> BlockCyclic:
        """The system that joins them, (5.16)."""
        return BlockCyclic(self.transitions, self.options)

    def starts(self, load: Array, slope: Array) -> Array:
        """Give the states at the starts, ``(sub-intervals, 2 modes)``, under modal loads and their slopes in time.

        Parameters
        ----------
        load
            Modal loads at the middles (N/sqrt(kg)), ``(sub-intervals, modes)``.
        slope
            Their rates in time (N/(s sqrt(kg))), of the same shape.

        Raises
        ------
        SolverError
            When the cycle cannot be closed, as at an undamped resonance, with mode and harmonic.
        """
        forced = self.oscillators.forced(load - slope * self.duration / 2, slope, self.duration)
        with blaming(self.blame):
            return self.cycle.solve(self._carried(forced))

    def blame(self) -> tuple[float, str]:
        """Find which mode is next to resonance, as `of_modes` does."""
        frequency = self.oscillators.omega.mean(axis=0) / (2 * np.pi)
        return of_modes(self.transitions, frequency, float(self.duration.sum()))

    def answer(self, load: Array, slope: Array) -> Array:
        """Give the states at the middles under modal loads and their slopes in time.

        Parameters
        ----------
        load, slope
            As of `starts`.

        Returns
        -------
        numpy.ndarray
            y and y'/omega of each mode, ``(sub-intervals, modes, 2)``.
        """
        return self.middles(self.starts(load, slope), load, slope)

    def middles(self, starts: Array, load: Array, slope: Array) -> Array:
        """Give the states at the middles, ``(sub-intervals, modes, 2)``, from those at the starts.

        Parameters
        ----------
        starts
            As `starts` gives them, ``(sub-intervals, 2 modes)``.
        load, slope
            As of `starts`.
        """
        start, half = load - slope * self.duration / 2, self.oscillators.transition(self.duration / 2)
        forced = self.oscillators.forced(start, slope, self.duration / 2)
        states = starts.reshape(len(starts), 2, -1).transpose(0, 2, 1)
        return np.einsum("kmij,kmj->kmi", half, states) + forced

    def viscous(self, state: Array) -> Array:
        """Give the coordinates y whose elastic forces are those of the damping, ``(sub-intervals, modes)``.

        Parameters
        ----------
        state
            y and y'/omega of each mode, ``(sub-intervals, modes, 2)``.
        """
        zeta, omega = self.oscillators.zeta, self.oscillators.omega
        return 2 * zeta * (state[..., 1] + times(self.straining, state[..., 0]) / omega)  # (E.12)


def straining(system: System, modes: Modes) -> Array:
    """Rates of each mode at which the turning of the links strains them, per coordinate of each mode (1/s).

    Parameters
    ----------
    system, modes
        The mechanism and its modes at the positions.

    Returns
    -------
    numpy.ndarray
        ``Phi^T M (P^T k P)^-1 P^T k P' Phi``, ``(angles, modes, modes)``.
    """
    return straining_by(system, modes, modes.shapes)


def straining_by(system: System, modes: Modes, displacements: Array) -> Array:
    """Give the same of displacements of the mechanism, ``(angles, modes, displacements)``.

    Parameters
    ----------
    system, modes, displacements
        As of `straining`, and coordinates q, ``(angles, displacements, coordinates)``.
    """
    strained, forward = modes.shapes / modes.omega[..., None] ** 2, system.transformation.forward
    if system.symmetric_stiffness:  # M phi is no more of the links' own stiffness
        alone, momenta = replace(system, terms=NOTHING), system.mass_times(modes.shapes).transpose(1, 0, 2)
        strained = np.stack([displacement_under(alone, momentum) for momentum in momenta], axis=1)
    stress = forward(system.values[:, None], strained)
    stress = (system.link_stiffness @ stress.reshape(-1, stress.shape[-1]).T).T.reshape(stress.shape)
    turned = forward(system.transformation.derivatives(system.motion)[0][:, None], displacements)
    return np.asarray(stress @ turned.transpose(0, 2, 1))


def require_joined(modes: int, sub_intervals: int) -> None:
    """Raise `TooLargeError` where so many modes in so many sub-intervals do not fit into memory.

    Parameters
    ----------
    modes
        Number of modes.
    sub_intervals
        Number of sub-intervals.
    """
    what = f"{sub_intervals} sub-intervals with {modes} modes"
    require_memory(SUB_INTERVALS.joined * sub_intervals * modes**2, what, "Take fewer modes, or fewer sub_intervals")


def _refuse_ringing(period: float, modes: Modes, state: Array, free: Array) -> None:
    """Raise when modes that the sub-intervals are too long for vibrate freely.

    The coefficients jump at the joins. A mode that swings a whole number of times in a sub-interval meets each jump in
    the same phase, and rings.

    Parameters
    ----------
    period
        Duration of the cycle (s).
    modes
        The modes kept.
    state
        Their displacements and velocities over omega at the middles, ``(angles, modes, 2)``.
    free
        The part of it that is free vibration.
    """
    fastest = modes.frequency.max(axis=0)
    needed = 2 * fastest * period
    unresolved = needed > len(state)
    energy = np.sum(modes.omega**2 * state[..., 0] ** 2, axis=1).max()
    energies = ((modes.omega**2)[..., None] * free**2).sum(axis=2).max(axis=0)
    ringing = np.sqrt(energies / max(energy, TINY)) * unresolved
    if ringing[worst := int(ringing.argmax())] > SUB_INTERVALS.largest_ringing:
        raise UnresolvedError(
            f"mode {worst + 1} ({fastest[worst]:.4g} Hz) is too fast for these sub_intervals: where two "
            f"of them meet it is set vibrating, with {ringing[worst]:.0%} of the whole amplitude, and the solution "
            "would be wrong. "
            f"{_without_ringing(int(np.argmax(unresolved)), math.ceil(needed.max()))}. analysis.allow_ringing "
            "lets it pass, and analysis.allow_coarse what the error estimate may refuse then"
        ).finer_by(solver="collocation")


def _without_ringing(slower: int, count: int) -> str:
    """Say what to do about modes that ring: only so many are slow enough, or so many sub-intervals resolve all."""
    ways = ["take analysis.solver = 'collocation', which needs no modes"]
    ways += [f"keep {slower} mode{'s' * (slower > 1)}"] if slower else []
    ways += [f"take at least {count} sub_intervals"] if count <= SUB_INTERVALS.most_advised else []
    return f"To avoid it, {', or '.join(ways)}; effects = 'auto' finds whether method quasi-static is enough"


def superpose(system: System, modes: Modes, y: Array, viscous: Array, load: Array, scene: Scene) -> ElasticResponse:
    """Give displacement and inertia from modal coordinates (5.3), with the static answer of the modes left out.

    Parameters
    ----------
    system, modes
        The mechanism and its modes at the positions.
    y, viscous
        Modal coordinates, and those whose elastic forces are those of the damping, ``(angles, modes)``.
    load
        Modal loads (N/sqrt(kg)), ``(angles, modes)``.
    scene
        States static correction.
    """
    displacement, elastic = superposed(modes, y), -(modes.omega**2) * y
    inertia = np.zeros_like(system.rigid_acceleration)
    if scene.analysis.static_correction:
        static = solve_static(system)
        displacement += static.displacement - superposed(modes, load / modes.omega**2)
        elastic = elastic + load  # y'' + 2 zeta omega y' = p - omega^2 y
        inertia += system.rigid_acceleration
    inertia += system.to_links(superposed(modes, elastic))
    return _damped(system, modes, viscous, ElasticResponse(displacement=displacement, inertia=inertia))


def _damped(system: System, modes: Modes, viscous: Array, balanced: ElasticResponse) -> ElasticResponse:
    """Take the forces of modal damping out of the inertia, into the links.

    Parameters
    ----------
    viscous
        Modal coordinates whose elastic forces they are, ``(angles, modes)``.
    balanced
        The response with the inertia that balances the elastic forces.
    """
    if not viscous.any():
        return balanced
    drag = superposed(modes, modes.omega**2 * viscous)
    if system.symmetric_stiffness:
        forces = system.mass_times(drag[:, None])[:, 0]
        strained = displacement_under(replace(system, terms=NOTHING), forces)
    else:
        strained = superposed(modes, viscous)  # M Phi omega^2 = P^T k P Phi
    damping = ModalDamping(system.to_links(strained), system.to_links(drag))
    return replace(balanced, inertia=balanced.inertia - damping.acceleration, modal_damping=damping)


def superposed(modes: Modes, values: Array) -> Array:
    """Sum of the modes' shapes times modal coordinates, ``(angles, coordinates)``.

    Parameters
    ----------
    modes
        The modes.
    values
        Modal coordinates, or loads or rates of them, ``(angles, modes)``.
    """
    return np.einsum("kmi,km->ki", modes.shapes, values)


def _joins(how: str, modes: Modes, step: Array, drag: Array) -> tuple[Array, Array]:
    """Matrices J and L of the joins, ``(angles, modes, modes)``: ``y_{k+1} = J y_k``, ``y'_{k+1} = J y'_k + L y_k``.

    Projected join: ``J = Phi_{k+1}^T M_{k+1} Phi_k``. The modes kept turn with the drive, and at a join they lose the
    displacement ``l = (Phi_k - Phi_{k+1} J) y_k``. As that happens over a step h, its momentum as the old modes see it,
    ``Phi_k^T M_k l/h``, would be lost too. The physical join gives it back: ``L = J (1 - B J)/h`` with
    ``B = Phi_k^T M_k Phi_{k+1}``. With all modes l is zero. L also holds the impulses ``-drag y`` of the damping over
    the halves of the sub-intervals before and after the join.
    """
    m, transfer = modes.omega.shape[1], modes.transfer
    if how == "modal":  # (5.14): each modal coordinate goes on by itself
        join = np.broadcast_to(np.eye(m), transfer.shape).copy()
        join[-1] = modes.closing
        return join, np.zeros_like(join)
    kick = -(transfer @ drag + np.roll(drag, -1, axis=0) @ transfer)
    if how == "physical":
        kick += transfer @ (np.eye(m) - modes.back @ transfer) / step
    return transfer, kick
