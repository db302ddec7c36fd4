"""Modal damping as a factor of its matrix over the coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.eigenmodes import natural
from fenics_mech.mechanism import System
from fenics_mech.mechanism.damping_factors import DampingFactor, FullFactor, ReducedFactor
from fenics_mech.mechanism.reduced_damping import ReducedLinks
from fenics_mech.response.mode_shapes import SHAPES, every, held, slowest

Ratio = float | tuple[float, ...]


@dataclass(frozen=True)
class FactorLimits:
    """How the factor of modes' damping is made."""

    fading: float = 3.0  # the damping fades out over the last third
    smooth: float = 1e-5  # of the damping of all modes: by how much four and six positions may differ
    few_smooth: float = 3e-5  # the same of few modes, which take longest to find; six positions err by a fifth of it
    parts: tuple[int, ...] = (1, 2, 4)  # of a step, at whose starts it may be found
    most_parts: int = 8  # of a step, after they were cut again: ten times the steps are points, or more


FACTOR = FactorLimits()


def damping_ratios(ratio: Ratio, omega: Array) -> Array:
    """Ratio of every mode (E.12), of the shape of `omega`; the last one stated holds for the modes after it.

    Parameters
    ----------
    ratio
        Damping ratio of all modes, or those of the slowest modes.
    omega
        Circular frequencies (rad/s), ``(angles, modes)``.
    """
    stated = np.atleast_1d(ratio)
    return np.broadcast_to(stated[np.minimum(np.arange(omega.shape[1]), len(stated) - 1)], omega.shape)


@dataclass(frozen=True)
class DampedModes:
    """Modes that are damped: at most so many, below an angular frequency (rad/s).

    Parameters
    ----------
    count
        Number of modes.
    fastest
        The frequency.
    links
        Links by few coordinates, in which the modes are found; None where those of the mechanism are few.
    """

    count: int
    fastest: float
    links: ReducedLinks | None = None

    def at(self, system: System) -> System:
        """Give the mechanism in which they are found, in the place of one at any angles."""
        return system if self.links is None else self.links.at(system)

    def factor(self, values: Array) -> DampingFactor:
        """Give a factor over the coordinates of that mechanism, ``(angles, modes, coordinates)``."""
        return FullFactor(values) if self.links is None else ReducedFactor(values, self.links)

    @property
    def seen(self) -> int | None:
        """Number of what they see of the coordinates, where these are not all."""
        return None if self.links is None else int(self.links.seen.shape[0])

    def share(self, omega: Array) -> Array:
        """Share 0..1 of its damping that a mode has. It fades out, so that its root is smooth where modes cross.

        Parameters
        ----------
        omega
            Circular frequencies of modes (rad/s), of any shape.
        """
        inside = np.clip(FACTOR.fading * (1 - omega / self.fastest), 0.0, 1.0)
        return np.asarray(inside**4 * (3 - 2 * inside) ** 2)


def modal_damping(ratio: Ratio, system: System, modes: DampedModes | None = None) -> DampingFactor | None:
    """Give F of ``F^T F = M Phi 2 zeta omega Phi^T M`` at every angle; None if nothing is damped.

    The modes are those of ``K^{-1} M``, so that the slow ones are exact beside members as good as rigid. With shapes
    ``Psi`` of unit stiffness, the matrix is ``K Psi (2 zeta/omega) Psi^T K``. F of all modes changes smoothly with the
    angle.

    Parameters
    ----------
    ratio
        Damping ratio, or those of the slowest modes.
    system
        The mechanism at the angles.
    modes
        Those that are damped; None for all.

    Raises
    ------
    SolverError
        When the stiffness is not positive.
    """
    if not np.any(ratio) or (modes is not None and not modes.count):  # all may be too fast for the steps
        return None
    key, system = (str(ratio), modes), natural(system)
    if modes is None:
        return FullFactor(system.once("modal damping", lambda: _of_all(ratio, *held(system)), key))
    here = modes.at(system)
    return modes.factor(here.once("modal damping", lambda: _of_slowest(ratio, *held(here), modes), key))


@dataclass(frozen=True, eq=False)
class KnownDamping:
    """The factor of modes' damping at equal parts of all steps of a closed cycle, to be interpolated between them.

    F is known but for a rotation of its rows. That of all modes is a factor of their damping ``F^T F``, which is
    interpolated. That of a few modes is turned to be like that of the position before it: the orthogonal Procrustes
    problem. Source: Golub and Van Loan, Matrix Computations, section 6.4.1.

    Parameters
    ----------
    factor
        F at the starts of the parts.
    unit
        What its columns are divided by for their numbers to be alike, ``(coordinates,)``.
    parts
        Parts in a step.
    """

    factor: DampingFactor
    unit: Array
    parts: int = 1

    @property
    def _of_modes(self) -> bool:
        """Whether its rows are those of modes, fewer than the coordinates."""
        return bool(self.factor.values.shape[1] < self.factor.values.shape[2])

    @cached_property
    def alike(self) -> dict[int, Array]:
        """What is interpolated, at the positions from two before each one to three after it."""
        scaled = self.factor.values / self.unit
        if self._of_modes:
            return _turned_alike(scaled)
        whole = scaled.transpose(0, 2, 1) @ scaled
        return {ahead: np.roll(whole, -ahead, axis=0) for ahead in range(-2, 4)}

    @cached_property
    def enough_parts(self) -> int:
        """Into how many parts each part is to be cut for it to be smooth; 0 where that is too many."""
        alike = self.alike
        differs = _largest(through(range(-1, 3), 0.5, alike) - through(range(-2, 4), 0.5, alike))
        rough = differs / ((FACTOR.few_smooth if self._of_modes else FACTOR.smooth) * _largest(alike[0]))
        # a polynomial through four positions errs by the fourth power of their distance
        return next((parts for parts in FACTOR.parts if rough <= parts**4), 0)

    def at(self, places: Array, together: int = 1) -> DampingFactor | None:
        """Interpolate by polynomials through six positions; None where some mode has no damping.

        Parameters
        ----------
        places
            Where in every step, 0..1.
        together
            How many steps are taken as one.
        """
        alike, parts, found = self.alike, self.parts * together, []
        for place in places:
            part, inside = divmod(place * parts, 1)
            here = {ahead: values[min(int(part), parts - 1) :: parts] for ahead, values in alike.items()}
            found.append(through(range(-2, 4), inside + max(0.0, part - parts + 1), here))
        values = np.stack(found, axis=1).reshape(-1, *found[0].shape[1:])
        try:
            factors = values if self._of_modes else np.linalg.cholesky(values).transpose(0, 2, 1)
        except np.linalg.LinAlgError:
            return None
        return replace(self.factor, values=factors * self.unit)


def _largest(matrices: Array) -> float:
    """Largest Frobenius norm of matrices, which no turning of axes changes."""
    return float(np.linalg.norm(matrices, axis=(1, 2)).max())


def _turned_alike(scaled: Array) -> dict[int, Array]:
    """Give F of the positions from two before each one to three after it, turned to be like that of this one."""
    left, _, right = np.linalg.svd(scaled @ np.roll(scaled, -1, axis=0).transpose(0, 2, 1))
    turn = left @ right  # makes F of the next position like that of this one
    alike, turned = {0: scaled}, turn
    for ahead in (1, 2, 3):
        alike[ahead] = np.matmul(turned, np.roll(scaled, -ahead, axis=0))
        turned = turned @ np.roll(turn, -ahead, axis=0)
    turned = back = np.roll(turn, 1, axis=0).transpose(0, 2, 1)
    for behind in (-1, -2):
        alike[behind] = np.matmul(turned, np.roll(scaled, -behind, axis=0))
        turned = turned @ np.roll(back, -behind, axis=0)
    return alike


def through(positions: range, place: float, alike: dict[int, Array]) -> Array:
    """Give the value of the polynomial through some positions at a place between 0 and 1.

    Parameters
    ----------
    positions
        The positions, about 0 and 1.
    place
        The place.
    alike
        Values at the positions, of any shape.
    """
    weights = [np.prod([(place - j) / (i - j) for j in positions if j != i]) for i in positions]
    return np.asarray(sum(weight * alike[i] for weight, i in zip(weights, positions)))


def _of_slowest(ratio: Ratio, mass: Stack, stiffness: Stack, modes: DampedModes) -> Array:
    """Factor of the damping of the slowest modes: each few angles begin from the shapes of the angle before them."""
    count = modes.count
    width = count + max(SHAPES.more_shapes, count // 2)
    shapes, found = np.random.default_rng(0).standard_normal((1, width, mass.size)), []
    for first in range(0, len(mass), SHAPES.at_a_time):
        part = slice(first, first + SHAPES.at_a_time)
        if width > SHAPES.most * mass.size:
            squares, forces = (each[:, :count] for each in every(mass[part], stiffness[part])[:2])
        else:
            squares, shapes, moved = slowest(mass[part], stiffness[part], shapes[-1], count)
            forces = moved[:, :count] / squares[..., None]
        inverse = np.sqrt(squares)
        ratios = damping_ratios(ratio, inverse) * modes.share(1 / inverse)
        found.append(np.sqrt(2 * ratios * inverse)[..., None] * forces)  # (E.12), of shapes of unit stiffness
    return np.concatenate(found)


def _of_all(ratio: Ratio, mass: Stack, stiffness: Stack) -> Array:
    """Factor of the damping of all modes."""
    squares, forces, shapes = every(mass, stiffness)
    inverse = np.sqrt(np.maximum(squares, 0))
    return shapes @ (np.sqrt(2 * damping_ratios(ratio, inverse) * inverse)[..., None] * forces)  # (E.12)
