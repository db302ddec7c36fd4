"""Two elastic links in a chain, by hand: what the slider-crank and the two-link manipulator have in common.

Link 1 is clamped to its driven shaft at O and ends in the pin A; link 2 begins there. Each link is described in its own
rigid-body frame, with x along it, w 90 degrees counter-clockwise and rotations phi = dw/dx; the translations of A are
in the fixed frame. The matrices of an element are integrated here by Gauss quadrature from the shape functions.

Numbers in parentheses are equations of Kaminski (1989).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tests.validation.reference.nine_element import Coupling, LinkMotion, LinkTransformation, as_angles

Array = NDArray[np.float64]
Pair = tuple[float, float]
"""One number for each of the two links."""


@dataclass(frozen=True)
class TwoLinkParameters:
    """Two straight uniform links and the masses at their ends.

    Parameters
    ----------
    lengths
        Lengths of the links (m).
    area, inertia, fibre
        Areas (m^2), second moments (m^4) and distances of the outer fibres (m).
    E, rho
        Young's modulus (Pa) and density (kg/m^3) of both.
    omega1
        2 pi over the duration of the cycle (rad/s).
    mass, turning
        Point mass (kg) and moment of inertia (kg m^2) at the end of each link.
    """

    lengths: Pair
    area: Pair
    inertia: Pair
    fibre: Pair
    E: float
    rho: float
    omega1: float
    mass: Pair = (0.0, 0.0)
    turning: Pair = (0.0, 0.0)


@dataclass(frozen=True)
class Ending:
    """How a node of a link moves with the model's dofs: two rows u, w from the fixed frame.

    Parameters
    ----------
    row
        Row of u in the link.
    columns
        The model's dofs.
    directions
        Their displacements in the fixed frame, ``(2, columns)``.
    """

    row: int
    columns: tuple[int, ...]
    directions: Array


def element_matrices(line_density: float, length: float, axial: float, bending: float) -> tuple[Array, Array, Array]:
    """Mass (7.1), stiffness (7.2) and gyroscopic matrix of an element by Gauss quadrature.

    Parameters
    ----------
    line_density
        rho A (kg/m).
    length
        Element length h (m).
    axial, bending
        EA (N) and EI (N m^2).

    Returns
    -------
    m, k, s : ndarray
        Shape ``(6, 6)`` each, unknowns u, w, phi at the first and the second node.
    """
    nodes, weights = np.polynomial.legendre.leggauss(4)
    x, h = (nodes + 1) / 2, length
    u, w, slope, curvature = np.zeros((4, 4, 6))
    u[:, 0], u[:, 3] = 1 - x, x  # (4.5), (4.8)
    w[:, 1], w[:, 2] = 1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3)  # (4.6), (4.7)
    w[:, 4], w[:, 5] = 3 * x**2 - 2 * x**3, h * (x**3 - x**2)  # (4.9), (4.10)
    slope[:, 0], slope[:, 3] = -1 / h, 1 / h
    curvature[:, 1], curvature[:, 2] = (12 * x - 6) / h**2, (6 * x - 4) / h
    curvature[:, 4], curvature[:, 5] = (6 - 12 * x) / h**2, (6 * x - 2) / h

    def integral(left: Array, right: Array) -> Array:
        return h / 2 * left.T @ (weights[:, None] * right)

    mass = line_density * (integral(u, u) + integral(w, w))
    stiffness = axial * integral(slope, slope) + bending * integral(curvature, curvature)
    return mass, stiffness, line_density * (integral(w, u) - integral(u, w))


class TwoLinkModel(ABC):
    """Matrices of the chain; subclasses say how it moves and where its second link ends.

    Every method takes crank angles, or phases 2 pi t/period, of shape ``(angles,)``.

    Parameters
    ----------
    parameters
        The links.
    elements
        Elements per link.
    """

    parameters: TwoLinkParameters

    def __init__(self, parameters: TwoLinkParameters, elements: int) -> None:
        if elements < 1:
            raise ValueError(f"a link needs at least one element, got {elements}")
        self.parameters, self.elements = parameters, elements

    @abstractmethod
    def motion(self, theta: ArrayLike) -> tuple[LinkMotion, LinkMotion]:
        """Rigid-body motion of the two links at angles `theta` (rad)."""

    @abstractmethod
    def layout(self) -> tuple[list[str], list[list[str]], list[list[Ending]]]:
        """Names of the dofs; of each link, the dof of every row ("" for none); of each link, its endings."""

    @property
    def size(self) -> int:
        """Number of degrees of freedom."""
        return len(self.layout()[0])

    @cached_property
    def element_lengths(self) -> Array:
        """Element length of each link (m), shape ``(2,)``."""
        return np.array(self.parameters.lengths) / self.elements

    def inner(self, link: int) -> list[str]:
        """Names of the dofs of a link's nodes between its ends."""
        return [f"{link}:{i}:{kind}" for i in range(1, self.elements) for kind in ("u", "w", "phi")]

    @cached_property
    def link_matrices(self) -> list[tuple[Array, Array, Array]]:
        """Constant m, k and s of each link in its own frame, the masses at its end included."""
        p, n, matrices = self.parameters, self.elements, []
        for link in range(2):
            ea, ei = p.E * p.area[link], p.E * p.inertia[link]
            element = element_matrices(p.rho * p.area[link], self.element_lengths[link], ea, ei)
            whole = np.zeros((3, 3 * n + 3, 3 * n + 3))
            for first in range(0, 3 * n, 3):
                whole[:, first : first + 6, first : first + 6] += element
            u, w, phi = 3 * n, 3 * n + 1, 3 * n + 2
            whole[0][[u, w, phi], [u, w, phi]] += [p.mass[link], p.mass[link], p.turning[link]]
            whole[2][[u, w], [w, u]] += [-p.mass[link], p.mass[link]]
            matrices.append((whole[0], whole[1], whole[2]))
        return matrices

    def transformations(self, theta: ArrayLike) -> list[LinkTransformation]:
        """P, P' and P'' of both links, (4.40)-(4.43)."""
        names, rows, endings = self.layout()
        answer = []
        for link, motion in enumerate(self.motion(theta)):
            fixed = np.zeros((len(rows[link]), len(names)))
            for row, name in enumerate(rows[link]):
                if name:
                    fixed[row, names.index(name)] = 1.0
            turn = np.exp(-1j * motion.angle)  # from the fixed frame into the link's
            omega, alpha = motion.omega, motion.alpha
            jets = (turn, -1j * omega * turn, (-1j * alpha - omega**2) * turn)
            parts = [np.repeat(fixed[None], len(turn), axis=0), *np.zeros((2, len(turn), *fixed.shape))]
            for part, jet in zip(parts, jets, strict=True):
                for ending in endings[link]:
                    for column, direction in zip(ending.columns, ending.directions.T, strict=True):
                        turned = jet * complex(*direction)
                        part[:, ending.row, column], part[:, ending.row + 1, column] = turned.real, turned.imag
            answer.append(LinkTransformation(*parts))
        return answer

    def mass_stiffness(self, theta: ArrayLike) -> tuple[Array, Array]:
        """M (4.57) and K (4.58), each of shape ``(angles, dofs, dofs)``."""
        mass = stiffness = np.zeros((np.size(theta), self.size, self.size))
        for (m, k, _), tr in zip(self.link_matrices, self.transformations(theta), strict=True):
            mass = mass + tr.value.swapaxes(1, 2) @ m @ tr.value
            stiffness = stiffness + tr.value.swapaxes(1, 2) @ k @ tr.value
        return mass, stiffness

    def coupling(self, theta: ArrayLike) -> Coupling:
        """Matrices of (4.66) besides M and K, (4.49)-(4.53)."""
        terms = np.zeros((5, np.size(theta), self.size, self.size))
        for link, ((m, _, s), tr, motion) in enumerate(
            zip(self.link_matrices, self.transformations(theta), self.motion(theta), strict=True)
        ):
            omega, alpha = motion.omega[:, None, None], motion.alpha[:, None, None]
            thrown = m.copy()  # the mass that centrifugal forces act on: a moment of inertia feels none
            thrown[-1, -1] -= self.parameters.turning[link]
            m_v, m_a = omega * s, alpha * s - omega**2 * thrown
            products = (m @ tr.rate, m_v @ tr.value, m @ tr.second, m_v @ tr.rate, m_a @ tr.value)
            terms += np.stack([tr.value.swapaxes(1, 2) @ product for product in products])
        return Coupling(*terms)

    def rigid_acceleration(self, theta: ArrayLike) -> list[Array]:
        """Rigid-body acceleration of each link's nodes in its frame (m/s^2, rad/s^2), ``(angles, link dofs)``."""
        answer = []
        for length, motion in zip(self.parameters.lengths, self.motion(theta), strict=True):
            x = np.linspace(0, length, self.elements + 1)
            along = motion.start[:, :1] - motion.omega[:, None] ** 2 * x
            across = motion.start[:, 1:] + motion.alpha[:, None] * x
            turning = np.repeat(motion.alpha[:, None], len(x), axis=1)
            answer.append(np.stack([along, across, turning], axis=-1).reshape(len(along), -1))
        return answer

    def load(self, theta: ArrayLike) -> Array:
        """Load -P^T m a_rigid (4.45), ``(angles, dofs)``."""
        parts = zip(self.link_matrices, self.transformations(theta), self.rigid_acceleration(theta), strict=True)
        total: Array = sum((-np.einsum("tij,ti->tj", tr.value, a @ m) for (m, _, _), tr, a in parts), start=np.zeros(1))
        return total


def link_motions(angle: Array, omega: Array, alpha: Array, first_length: float) -> tuple[LinkMotion, LinkMotion]:
    """Motion of both links from their angles in the fixed frame and the derivatives, ``(angles, 2)`` each."""
    at_a = first_length * (1j * alpha[:, 0] - omega[:, 0] ** 2) * np.exp(1j * (angle[:, 0] - angle[:, 1]))
    starts = (np.zeros((len(angle), 2)), np.stack([at_a.real, at_a.imag], axis=1))
    first, second = (LinkMotion(angle[:, i], omega[:, i], alpha[:, i], starts[i]) for i in range(2))
    return first, second


__all__ = ["Ending", "TwoLinkModel", "TwoLinkParameters", "as_angles", "element_matrices", "link_motions"]
