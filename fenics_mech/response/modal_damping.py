"""Modal damping as a factor of its matrix over the coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.beam_links import reducible
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import not_positive
from fenics_mech.mechanism.modal_forces import MATRICES
from fenics_mech.mechanism.reduced_damping import ReducedFactor, ReducedLinks, elastic_stiffness
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.scene import Scene
from fenics_mech.scene.springs_dampers import HingeSpring

Ratio = float | tuple[float, ...]


@dataclass(frozen=True)
class DampedModesLimits:
    """Which modes are damped, and how exactly they are found."""

    small: int = 40  # coordinates, up to which all modes are damped: there full matrices are as fast
    fastest: float = 128.0  # times the lowest frequency; measured: 2e-4 of a member that is strained little
    weak: float = 0.02  # ratio up to which that is enough; beyond it is more, as the root of the ratio
    resolved: float = 4.0  # rad in a step, up to which steps may resolve a vibration
    fading: float = 3.0  # the damping fades out over the last third
    at_a_time: int = 20  # angles, whose shapes are alike and stay in the processor's cache
    more_shapes: int = 8  # beside those wanted
    most: float = 0.5  # of the coordinates, as shapes: with more of them all modes are found, which is as fast
    most_iterations: int = 60  # of a subspace, before modes count as not found
    many: int = 120  # coordinates, from which modes are looked for by fewer
    reduced: float = 0.5  # of the coordinates, up to which fewer are worth their while
    clamped: float = 2.0  # frequency of the members' clamped modes in them, over that of the fastest damped mode
    converged: float = 1e-4  # change of 1/omega^2 of the fastest mode in an iteration: for the slow ones it is 1e-10
    smooth: float = 1e-5  # of the damping of all modes: by how much four and six positions may differ
    few_smooth: float = 3e-5  # the same of few modes, which take longest to find; six positions err by a fifth of it


DAMPED = DampedModesLimits()


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
        inside = np.clip(DAMPED.fading * (1 - omega / self.fastest), 0.0, 1.0)
        return np.asarray(inside**4 * (3 - 2 * inside) ** 2)


def damped_modes(scene: Scene, system: System, enough: float = DAMPED.fastest) -> DampedModes | None:
    """Find which modes are damped in a periodic motion of many coordinates; None for all.

    These are all that its steps resolve, and those up to some times the lowest frequency. Faster ones follow the loads
    without vibrating: their damping would change the strains of the seed four-bar by 2e-5, and in a member that is
    strained little 2e-4 of its own. The frequency is relative to the lowest one, so that it is alike in similar scenes.
    All are damped beside torsional springs, which fast modes wind, and where the solver's steps let them ring: at
    Gauss points after impulses and jumps.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism over a cycle.
    enough
        Times the lowest frequency, up to which modes are damped that the steps do not resolve.
    """
    wound = any(isinstance(spring, HingeSpring) for spring in scene.springs.values())
    rings = scene.analysis.scheme == "gauss" and Steps.of(scene).disturbed
    if not np.any(scene.damping.ratio) or system.size <= DAMPED.small or wound or rings:
        return None
    enough *= math.sqrt(max(1.0, float(np.max(scene.damping.ratio)) / DAMPED.weak))
    resolved = DAMPED.resolved * scene.analysis.sub_intervals / abs(scene.period)
    return system.once("damped modes", lambda: _up_to(scene, system, enough, resolved), (enough, resolved))


def _up_to(scene: Scene, system: System, enough: float, resolved: float) -> DampedModes | None:
    """Modes up to so many times the lowest frequency, and to one that is resolved (rad/s); None if they are many."""
    mass, stiffness = _held(system)
    some = np.random.default_rng(0).standard_normal((DAMPED.more_shapes, mass.size))
    lowest = float(1 / np.sqrt(_slowest(mass, stiffness, some, 1)[0].max()))
    fastest = lowest * 2.0 ** math.ceil(math.log2(max(enough, resolved / lowest)))
    links = _reduced(scene, system, fastest)
    if links is not None:
        mass, stiffness = _held(links.at(system))
    slower = (stiffness + (-(fastest**2)) * mass).factors.pivots < 0  # as many as frequencies below it (Sylvester)
    count = int(np.sum(slower, axis=1).max())
    few = links is not None or count < MATRICES.few_modes * mass.size
    return DampedModes(count, fastest, links) if few else None


def _reduced(scene: Scene, system: System, fastest: float) -> ReducedLinks | None:
    """Links by few coordinates, for modes up to a frequency (rad/s); None where these are not few."""
    reduced = system.beams.reduction is not None or system.transformation.base is not None
    if reduced or system.terms.axial_stiffness or system.size < DAMPED.many:
        return None
    links = ReducedLinks.of(scene, system, reducible(scene, system.beams), DAMPED.clamped * fastest)
    return links if links.transformation.shape[1] < DAMPED.reduced * system.size else None


def modal_damping(ratio: Ratio, system: System, modes: DampedModes | None = None) -> Array | ReducedFactor | None:
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

    Returns
    -------
    numpy.ndarray or ReducedFactor or None
        ``(angles, modes, coordinates)``, or over fewer coordinates.

    Raises
    ------
    SolverError
        When the stiffness is not positive.
    """
    if not np.any(ratio):
        return None
    key = str(ratio), modes
    if modes is None:
        return system.once("modal damping", lambda: _of_all(ratio, *_held(system)), key)
    if modes.links is None:
        return system.once("modal damping", lambda: _of_slowest(ratio, *_held(system), modes), key)
    here = modes.links.at(system)
    return ReducedFactor(here.once("modal damping", lambda: _of_slowest(ratio, *_held(here), modes), key), modes.links)


def damping_between(damping: Array | ReducedFactor, start: Equation, places: Array) -> Array | ReducedFactor | None:
    """Interpolate the factor of modes' damping as `interpolated_damping` does, over many coordinates or few.

    Parameters
    ----------
    damping
        The factor at the starts of equal steps of a closed cycle.
    start
        The equation there.
    places
        Where in every step, 0..1.
    """
    if not isinstance(damping, ReducedFactor):
        return interpolated_damping(damping, np.sqrt(start.links_stiffness.diagonal.mean(axis=0)), places)
    stiffness = elastic_stiffness(damping.links, start.system)
    found = interpolated_damping(damping.factor, np.sqrt(stiffness.diagonal.mean(axis=0)), places)
    return None if found is None else ReducedFactor(found, damping.links)


def interpolated_damping(damping: Array, unit: Array, places: Array) -> Array | None:
    """Interpolate the factor F of modes' damping between equal steps of a closed cycle; None where it is not smooth.

    F is known but for a rotation of its rows. That of all modes is a factor of their damping ``F^T F``, which is
    interpolated. That of a few modes is turned to be like that of the position before it: the orthogonal Procrustes
    problem. Source: Golub and Van Loan, Matrix Computations, section 6.4.1.

    Parameters
    ----------
    damping
        F at the starts of the steps, ``(steps, modes, coordinates)``.
    unit
        What coordinates are multiplied by for their numbers to be alike, ``(coordinates,)``.
    places
        Where in every step, 0..1.

    Returns
    -------
    numpy.ndarray or None
        ``(steps x places, modes, coordinates)``.
    """
    scaled = damping / unit
    if scaled.shape[1] < scaled.shape[2]:
        factors = _through_six(_turned_alike(scaled), places, DAMPED.few_smooth)
        return None if factors is None else factors * unit
    whole = scaled.transpose(0, 2, 1) @ scaled
    products = _through_six({ahead: np.roll(whole, -ahead, axis=0) for ahead in range(-2, 4)}, places, DAMPED.smooth)
    if products is None:
        return None
    try:
        return np.linalg.cholesky(products).transpose(0, 2, 1) * unit
    except np.linalg.LinAlgError:  # some mode has no damping
        return None


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


def _through_six(alike: dict[int, Array], places: Array, smooth: float) -> Array | None:
    """Take polynomials through six positions of every step; None where one through four differs by more."""

    def through(positions: range, place: float) -> Array:
        weights = [np.prod([(place - j) / (i - j) for j in positions if j != i]) for i in positions]
        return np.asarray(sum(weight * alike[i] for weight, i in zip(weights, positions)))

    difference = through(range(-1, 3), 0.5) - through(range(-2, 4), 0.5)
    if not np.abs(difference).max() <= smooth * np.abs(alike[0]).max():
        return None
    return np.stack([through(range(-2, 4), place) for place in places], axis=1).reshape(-1, *alike[0].shape[1:])


def _held(system: System) -> tuple[Stack, Stack]:
    """Mass and positive stiffness at the angles."""
    return system.once("held matrices", lambda: _positive(system))


def _positive(system: System) -> tuple[Stack, Stack]:
    mass, stiffness = system.held_matrices()
    if len(indefinite := not_positive(stiffness)):
        least = [np.linalg.eigvalsh(stiffness.dense(k))[0] for k in indefinite]
        theta = np.degrees(system.motion.theta[indefinite[int(np.argmin(least))]])
        raise SolverError(f"the stiffness is not positive at drive angle {theta:.6g} deg: it has no modes to damp")
    return mass, stiffness


def _of_slowest(ratio: Ratio, mass: Stack, stiffness: Stack, modes: DampedModes) -> Array:
    """Factor of the damping of the slowest modes: each few angles begin from the shapes of the angle before them."""
    count = modes.count
    width = count + max(DAMPED.more_shapes, count // 2)
    shapes, found = np.random.default_rng(0).standard_normal((1, width, mass.size)), []
    for first in range(0, len(mass), DAMPED.at_a_time):
        part = slice(first, first + DAMPED.at_a_time)
        if width > DAMPED.most * mass.size:
            squares, forces = (each[:, :count] for each in _every(mass[part], stiffness[part])[:2])
        else:
            squares, shapes, moved = _slowest(mass[part], stiffness[part], shapes[-1], count)
            forces = moved[:, :count] / squares[..., None]
        inverse = np.sqrt(squares)
        ratios = damping_ratios(ratio, inverse) * modes.share(1 / inverse)
        found.append(np.sqrt(2 * ratios * inverse)[..., None] * forces)  # (E.12), of shapes of unit stiffness
    return np.concatenate(found)


def _slowest(mass: Stack, stiffness: Stack, start: Array, count: int) -> tuple[Array, Array, Array]:
    """Iterate the subspace of some shapes at all angles (Bathe and Wilson, 1972).

    Returns
    -------
    tuple
        ``1/omega^2`` of so many modes, ``(angles, count)``, and all shapes of unit stiffness and their momenta,
        ``(angles, shapes, coordinates)``.
    """
    shapes, squares = np.broadcast_to(start, (len(mass), *start.shape)), np.zeros((len(mass), count))
    for _ in range(DAMPED.most_iterations):
        shapes = stiffness.solve(mass.times(shapes))
        lower = np.linalg.cholesky(shapes @ stiffness.times(shapes).transpose(0, 2, 1))
        shapes = np.linalg.inv(lower) @ shapes
        moved, before = mass.times(shapes), squares
        every, turn = np.linalg.eigh(shapes @ moved.transpose(0, 2, 1))  # ascending
        squares, turn = every[:, : -count - 1 : -1], turn[..., ::-1].transpose(0, 2, 1)
        shapes, moved = turn @ shapes, turn @ moved
        if np.all(np.abs(squares - before) < DAMPED.converged * squares):
            break
    return squares, shapes, moved


def _of_all(ratio: Ratio, mass: Stack, stiffness: Stack) -> Array:
    """Factor of the damping of all modes."""
    squares, forces, shapes = _every(mass, stiffness)
    inverse = np.sqrt(np.maximum(squares, 0))
    return shapes @ (np.sqrt(2 * damping_ratios(ratio, inverse) * inverse)[..., None] * forces)  # (E.12)


def _every(mass: Stack, stiffness: Stack) -> tuple[Array, Array, Array]:
    """Find all modes, which LAPACK does in whole arrays.

    Returns
    -------
    tuple
        ``1/omega^2``, ``(angles, modes)``. The elastic forces of shapes of unit stiffness, ``(angles, modes,
        coordinates)``. An orthonormal matrix that turns these to be smooth, ``(angles, coordinates, modes)``.
    """
    unit = np.sqrt(stiffness.diagonal)
    pairs = unit[:, :, None] * unit[:, None, :]  # so that rounding of stiff coordinates stays with them
    lower = np.linalg.cholesky(stiffness.full / pairs)
    scaled = np.linalg.solve(lower, np.linalg.solve(lower, mass.full / pairs).transpose(0, 2, 1))
    squares, shapes = (part[..., ::-1] for part in np.linalg.eigh(scaled))  # (E.2) of 1/omega^2
    return squares, (unit[:, :, None] * lower @ shapes).transpose(0, 2, 1), shapes
