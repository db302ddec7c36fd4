"""How disturbances of a periodic motion turn in the complex plane, followed through a cycle in the links' own axes.

A Floquet multiplier gives the angle of its disturbance but for whole turns in a cycle. Those are counted along the
cycle. Coordinates of pins are along fixed axes, in which the disturbance of a link that rotates turns with it, so that
the count is made in the link's own axes. There the mode shapes of a spinning link do not turn.

Source: Nayfeh and Balachandran, Applied Nonlinear Dynamics, ch. 3; whirl in both frames: Genta, Dynamics of Rotating
Systems, ch. 2.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index, summed
from fenics_mech.eigenmodes import Modes
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism import System
from fenics_mech.response.periodic.flow import Flow

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class TurningLimits:
    """Limits of the count of turns."""

    least_share: float = 0.3  # of the turns by its speed, which a disturbance has at least where it vibrates
    equal: float = 1e-6  # relative distance of multipliers that count as one
    dependent: float = 1e-10  # part of a disturbance that others of its multiplier do not hold, for them to separate
    even: float = 1e-6  # difference of two links' parts of a disturbance, up to which the first link counts
    in_mode: float = 0.6  # part of a disturbance in one mode, above which its turns are that mode's; a whirl has halves


TURNING = TurningLimits()


@dataclass(frozen=True)
class LinkAxes:
    """The links' coordinates ``v = P q`` in their own axes, at the starts of the steps of a cycle.

    Parameters
    ----------
    rows, columns
        Links' coordinate and coordinate q of each nonzero of P.
    values, rates
        Nonzeros of P and of its time derivative (1/s), ``(steps, nonzeros)``.
    mass
        Mass matrix m of all links, which joins no two of them.
    link
        Link of each of the links' coordinates.
    names
        Names of the links.
    position
        Number of the position whose modes each step takes, ``(steps,)``; or one for all.
    """

    rows: Index
    columns: Index
    values: Array
    rates: Array
    mass: sp.csr_matrix
    link: Index
    names: tuple[str, ...]
    position: Index = field(default_factory=lambda: np.zeros(1, dtype=int))

    @classmethod
    def of(cls, system: System, motion: Motion) -> LinkAxes:
        """Take the axes of a mechanism at the drive angles of a motion, which are the starts of all steps.

        Parameters
        ----------
        system
            The mechanism.
        motion
            Its rigid motion at the starts of all steps.
        """
        transformation = system.transformation
        return cls(
            rows=transformation.rows,
            columns=transformation.columns,
            values=transformation.values(motion),
            rates=transformation.derivatives(motion)[0],
            mass=system.link_mass,
            link=system.link_of_coordinate,
            names=tuple(system.motion.links),
            position=np.abs(motion.theta[:, None] - system.motion.theta).argmin(axis=1),
        )

    def carried(self, q: Complex, rate: Complex) -> tuple[Complex, Complex]:
        """Displacement and velocity in link axes, each ``(steps, disturbances, links' coordinates)``.

        They have one step more than there are: the last is the first of the next cycle.

        Parameters
        ----------
        q, rate
            q and q' at the starts of all steps and at the end, ``(steps + 1, disturbances, coordinates)`` each.
        """
        values, rates = (np.concatenate([part, part[:1]])[:, None] for part in (self.values, self.rates))
        size = len(self.link)
        moved = values * q[..., self.columns], values * rate[..., self.columns] + rates * q[..., self.columns]
        v, velocity = (summed(part, self.rows, size) for part in moved)
        return v, velocity

    def in_mode(self, modes: Modes, v: Complex, velocity: Complex) -> tuple[Complex, Complex]:
        """Give of v and v' what the mode with the largest part holds, where that is most of v; else both as they are.

        Gauss points hardly damp what is too fast for the steps, such as a mass on a stiff arm. Its velocity may be
        larger than that of a slow disturbance, which would seem to turn as fast.

        Parameters
        ----------
        modes
            The modes of the mechanism held at its positions.
        v, velocity
            As `carried` gives them.
        """
        shapes = self.values[:, None] * modes.shapes[self.position][..., self.columns]
        shapes = np.concatenate([every := summed(shapes, self.rows, len(self.link)), every[:1]])
        momenta = self.momenta(shapes)
        parts = np.stack([np.einsum("kdi,kmi->kdm", part, momenta, optimize=True) for part in (v, velocity)])
        share = np.sum(np.abs(parts[0]) ** 2, axis=0) / np.sum(v.conj() * self.momenta(v), axis=(0, 2)).real[:, None]
        most, own = share.argmax(axis=1), np.arange(len(share))
        of_mode = parts[:, :, own, most, None] * shapes[:, most]
        found = np.where((share.max(axis=1) > TURNING.in_mode)[:, None], of_mode, (v, velocity))
        return found[0], found[1]

    def momenta(self, v: Complex) -> Complex:
        """``m v``, of the shape of v.

        Parameters
        ----------
        v
            Displacements or velocities in link axes, ``(..., links' coordinates)``.
        """
        return np.asarray((self.mass @ v.reshape(-1, v.shape[-1]).T).T).reshape(v.shape)


def turns(
    axes: LinkAxes, flow: Flow, values: Complex, states: Complex, modes: Modes
) -> tuple[Array, Index, NDArray[np.bool_]]:
    """Count the turns of disturbances in a cycle: whole ones, and the part that their multipliers give.

    With ``a = v - i v'/speed`` also a real disturbance turns, ``cos t`` being ``exp(i t)``. The angle between one step
    and the next is that of ``a_k^H m a_(k+1)``, which the modes' shapes do not enter but for how they change. Where one
    mode holds most of the disturbance they are its own: what else there is may be too fast for the steps.

    Parameters
    ----------
    axes
        The links' axes.
    flow
        The steps.
    values, states
        The multipliers, and the disturbances at the start of the cycle, ``(disturbances, states)``.
    modes
        The modes of the mechanism held at its positions.

    Returns
    -------
    tuple
        Turns in the links' axes, weighted by mass, negative where the disturbance turns clockwise in the complex plane.
        The index of the link that has the largest part of it. Whether it vibrates; with a strong damper it may creep
        instead. Each is ``(disturbances,)``.
    """
    v, velocity = axes.in_mode(modes, *axes.carried(*_through(flow, states, None)))
    parts = summed(np.sum(v.conj() * axes.momenta(v), axis=0).real, axes.link, len(axes.names))
    link = (parts > (1 - TURNING.even) * parts.max(axis=1, keepdims=True)).argmax(axis=1)
    momenta = axes.momenta(velocity)
    slow, fast = (np.sum(a.conj() * b, axis=(0, 2)) for a, b in ((v, axes.momenta(v)), (velocity, momenta)))
    sense = np.sum(v.conj() * momenta, axis=(0, 2)).imag
    tiny = np.finfo(float).tiny
    speed = np.where(sense < 0, -1, 1) * np.sqrt(np.maximum(fast.real, tiny) / np.maximum(slow.real, tiny))
    ahead = v - 1j * velocity / speed[:, None]
    angle = np.angle(np.sum(ahead[:-1].conj() * axes.momenta(ahead[1:]), axis=-1))
    expected = speed * flow.duration[:, None]  # in a step; it may be more than half a turn
    turned = np.sum(expected + np.mod(angle - expected + np.pi, 2 * np.pi) - np.pi, axis=0) / (2 * np.pi)
    part = np.angle(values) / (2 * np.pi)
    turned = np.round(turned - part) + part
    return turned, link, np.abs(turned) > TURNING.least_share * np.abs(speed) * np.sum(flow.duration) / (2 * np.pi)


def separated(axes: LinkAxes, flow: Flow, values: Complex, states: Complex) -> Complex:
    """Separate disturbances of equal multipliers by the speeds at which they turn.

    Whirls forward and backward, at ``omega - speed`` and ``omega + speed`` in the axes of a turning link, have the same
    multiplier, and any combination of them is an eigenvector. Those taken have extreme mean speeds.

    Parameters
    ----------
    axes
        The links' axes.
    flow
        The steps.
    values
        The multipliers, ``(disturbances,)``.
    states
        The disturbances at the start of the cycle, ``(disturbances, states)``.

    Returns
    -------
    numpy.ndarray
        Disturbances of the same shape.
    """
    found, left = states.copy(), np.ones(len(values), dtype=bool)
    for i, value in enumerate(values):
        same = np.flatnonzero(left & (np.abs(values - value) <= TURNING.equal * abs(value)))
        if not left[i] or not value:
            continue
        left[same] = False
        if len(same) > 1:
            found[same] = _by_speed(axes, flow, states[same], abs(value))
    return found


def _by_speed(axes: LinkAxes, flow: Flow, states: Complex, size: float) -> Complex:
    """Combine disturbances that grow alike to those of extreme mean speeds."""
    v, velocity = axes.carried(*_through(flow, states, size))
    momenta = axes.momenta(v[:-1])
    weight = np.einsum("kih,kjh->ij", v[:-1].conj(), momenta)
    product = np.einsum("kih,kjh->ij", momenta.conj(), velocity[:-1])
    unit = 1 / np.sqrt(np.maximum(np.diag(weight).real, np.finfo(float).tiny))
    weight, product = (matrix * np.outer(unit, unit) for matrix in (weight, (product - product.conj().T) / 2j))
    squares, vectors = np.linalg.eigh(weight)
    if squares[0] < TURNING.dependent:
        return states
    whiten = vectors / np.sqrt(squares)
    combined = whiten @ np.linalg.eigh(whiten.conj().T @ product @ whiten)[1]
    return np.asarray((combined * unit[:, None]).T @ states)


def alike(flow: Flow, states: Complex) -> Complex:
    """Give disturbances at the starts of all steps and at the end, each of the same size at every start.

    Parameters
    ----------
    flow
        The steps.
    states
        The disturbances at the start of the cycle, ``(disturbances, states)``.

    Returns
    -------
    numpy.ndarray
        ``(steps + 1, disturbances, states)``.
    """
    passed = _passed(flow, states)[0]
    return passed / np.maximum(np.linalg.norm(passed, axis=-1, keepdims=True), np.finfo(float).tiny)


def _passed(flow: Flow, states: Complex) -> tuple[Complex, Array]:
    """Carry disturbances through the cycle, with the powers of e that they are to be multiplied by."""
    followed = np.ones(len(states), dtype=bool)
    for i, state in enumerate(states[1:], 1):
        followed[i] = not (followed[i - 1] and np.array_equal(state, states[i - 1].conj()))
    passed, powers = flow.passed(states[followed])
    of = np.cumsum(followed) - 1
    return np.where(followed[:, None], passed[:, of], passed[:, of].conj()), powers[:, of]


def _through(flow: Flow, states: Complex, size: float | None) -> tuple[Complex, Complex]:
    """Give q and q' of disturbances at the starts of all steps and at the end.

    Both are ``(steps + 1, disturbances, coordinates)``. Each is scaled to the same size at every start, or by the
    growth to `size` in a cycle, so that what dies out counts no less.
    """
    if size is None:
        passed = alike(flow, states)
    else:
        passed, powers = _passed(flow, states)
        even = np.log(size) / len(flow.duration) * np.arange(len(passed))
        passed = passed * np.exp(powers - even[:, None])[..., None]
    q, rate = np.split(passed, [flow.size], axis=-1)
    return q, rate / flow.mean_step
