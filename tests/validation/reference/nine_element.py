"""The dissertation's finite-element model of the four-bar (section 7.2) with its matrices typed in by hand.

Each link is cut into equal Euler beam elements; three of them per link make the nine elements and 27 degrees of freedom
of figure 7.1. A link is described in its own rigid-body frame: x from O to A, from A to B and from C to B, w 90 degrees
counter-clockwise from it, rotations phi = dw/dx. The translations of the joints A and B are in the fixed frame. The
crank is clamped at O, where the drive imposes its angle; the pin at C leaves the follower's rotation free.

Numbers in parentheses are the dissertation's equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh

from .mecqbar import positions, rates
from .parameters import FourBarParameters

Array = NDArray[np.float64]
DofLabel = tuple[str, float, str] | tuple[str, str]

LINKS = ("crank", "coupler", "follower")


def element_mass(line_density: float, length: float) -> Array:
    """Consistent mass matrix of a beam element.

    Parameters
    ----------
    line_density
        Mass per length, rho A (kg/m).
    length
        Element length (m).

    Returns
    -------
    ndarray
        Shape ``(6, 6)``, unknowns u, w, phi at the first and the second node (kg, kg m, kg m^2).
    """
    h = length
    matrix = [
        [1 / 3, 0, 0, 1 / 6, 0, 0],
        [0, 13 / 35, 11 * h / 210, 0, 9 / 70, -13 * h / 420],
        [0, 11 * h / 210, h**2 / 105, 0, 13 * h / 420, -(h**2) / 140],
        [1 / 6, 0, 0, 1 / 3, 0, 0],
        [0, 9 / 70, 13 * h / 420, 0, 13 / 35, -11 * h / 210],
        [0, -13 * h / 420, -(h**2) / 140, 0, -11 * h / 210, h**2 / 105],
    ]
    return line_density * length * np.array(matrix)  # (7.1)


def element_stiffness(young: float, area: float, inertia: float, length: float) -> Array:
    """Stiffness matrix of a beam element.

    Parameters
    ----------
    young
        Young's modulus (Pa).
    area
        Cross-section area (m^2).
    inertia
        Second moment of area (m^4).
    length
        Element length (m).

    Returns
    -------
    ndarray
        Shape ``(6, 6)``, unknowns u, w, phi at the first and the second node (N/m, N, N m).
    """
    a, i, h = area, inertia, length
    matrix = [
        [a, 0, 0, -a, 0, 0],
        [0, 12 * i / h**2, 6 * i / h, 0, -12 * i / h**2, 6 * i / h],
        [0, 6 * i / h, 4 * i, 0, -6 * i / h, 2 * i],  # erratum: the last entry is printed -2I
        [-a, 0, 0, a, 0, 0],
        [0, -12 * i / h**2, -6 * i / h, 0, 12 * i / h**2, -6 * i / h],
        [0, 6 * i / h, 2 * i, 0, -6 * i / h, 4 * i],  # erratum: the third entry is printed -2I
    ]
    return young / length * np.array(matrix)  # (7.2)


def element_gyroscopic(line_density: float, length: float) -> Array:
    """Gyroscopic matrix s of a beam element, ``v^T s d = int rho A (u_d w_v - w_d u_v) dx``.

    With the linear and Hermite shapes (4.5)-(4.10) the integrals of N1 and N4 against N2, N3, N5, N6 are 7/20, h/20,
    3/20, -h/30 and 3/20, h/30, 7/20, -h/20 times the length. T^T T' is omega times a quarter turn, so omega s is the
    matrix of (4.29), and alpha s - omega^2 m that of (4.30).

    Parameters
    ----------
    line_density
        Mass per length, rho A (kg/m).
    length
        Element length (m).

    Returns
    -------
    ndarray
        Shape ``(6, 6)``, skew-symmetric (kg, kg m).
    """
    h = length
    matrix = [
        [0, -7 / 20, -h / 20, 0, -3 / 20, h / 30],
        [7 / 20, 0, 0, 3 / 20, 0, 0],
        [h / 20, 0, 0, h / 30, 0, 0],
        [0, -3 / 20, -h / 30, 0, -7 / 20, h / 20],
        [3 / 20, 0, 0, 7 / 20, 0, 0],
        [-h / 30, 0, 0, -h / 20, 0, 0],
    ]
    return line_density * length * np.array(matrix)


def as_angles(theta: ArrayLike) -> Array:
    """Crank angles (rad) as an array of shape ``(angles,)``; a single number is one angle."""
    angles: Array = np.atleast_1d(np.asarray(theta, dtype=float))
    return angles


@dataclass(frozen=True)
class LinkMotion:
    """Rigid-body motion of one link, one number per crank angle.

    Parameters
    ----------
    angle, omega, alpha
        Angle from OC (rad), angular speed (rad/s) and acceleration (rad/s^2), shape ``(angles,)``.
    start
        Acceleration of the link's first point along its own axes (m/s^2), shape ``(angles, 2)``.
    """

    angle: Array
    omega: Array
    alpha: Array
    start: Array


@dataclass(frozen=True)
class LinkTransformation:
    """``u_link = P q`` of one link and its derivatives in time (4.41)-(4.43).

    Parameters
    ----------
    value, rate, second
        P, P' (1/s) and P'' (1/s^2), shape ``(angles, link dofs, model dofs)``.
    """

    value: Array
    rate: Array
    second: Array


@dataclass(frozen=True)
class Coupling:
    """Matrices of (4.66) that couple elastic and rigid-body motion, shape ``(angles, dofs, dofs)``.

    Parameters
    ----------
    Md
        P^T m P' (4.52).
    Mv
        P^T m_v P (4.53).
    Mdd
        P^T m P'' (4.49).
    Mdv
        P^T m_v P' (4.50).
    Ma
        P^T m_a P (4.51).
    """

    Md: Array
    Mv: Array
    Mdd: Array
    Mdv: Array
    Ma: Array

    @property
    def damping(self) -> Array:
        """Factor of q' in (4.66), 2 (Md + Mv)."""
        return 2 * (self.Md + self.Mv)

    @property
    def stiffness(self) -> Array:
        """Factor of q in (4.66) next to K: Mdd + 2 Mdv + Ma."""
        return self.Mdd + 2 * self.Mdv + self.Ma


class NineElementModel:
    """The four-bar as beam elements typed in by hand.

    Every method takes crank angles of shape ``(angles,)`` (or one number, which counts as one angle) and answers
    with arrays whose first axis is the angle.

    Parameters
    ----------
    parameters
        The four-bar; the dissertation's when left out.
    elements
        Elements per link; 3 gives the nine elements of figure 7.1.
    """

    def __init__(self, parameters: FourBarParameters | None = None, elements: int = 3) -> None:
        if elements < 1:
            raise ValueError(f"a link needs at least one element, got {elements}")
        self.parameters = parameters or FourBarParameters()
        self.elements = elements

    @cached_property
    def dof_labels(self) -> list[DofLabel]:
        """One label per dof: ``(link, s, "u" | "w" | "phi")``, s = 0..1 along the link, or ``(joint, "X" | "Y")``."""
        inner = [round(i / self.elements, 12) for i in range(1, self.elements)]
        labels: list[DofLabel] = [("crank", s, kind) for s in inner for kind in ("u", "w", "phi")]
        labels += [("A", "X"), ("A", "Y"), ("crank", 1.0, "phi"), ("coupler", 0.0, "phi")]
        labels += [("coupler", s, kind) for s in inner for kind in ("u", "w", "phi")]
        labels += [("B", "X"), ("B", "Y"), ("coupler", 1.0, "phi"), ("follower", 1.0, "phi")]
        labels += [("follower", s, kind) for s in inner for kind in ("u", "w", "phi")]
        return [*labels, ("follower", 0.0, "phi")]

    @property
    def size(self) -> int:
        """Number of degrees of freedom."""
        return len(self.dof_labels)

    @cached_property
    def element_lengths(self) -> Array:
        """Element length of each link (m), shape ``(3,)``."""
        return np.array(self.parameters.lengths) / self.elements

    @cached_property
    def link_matrices(self) -> list[tuple[Array, Array, Array]]:
        """Constant m, k and s of each link in its own frame (4.32)-(4.35), point masses included."""
        p, n = self.parameters, self.elements
        matrices = []
        for link, tip_mass in enumerate((p.mass_A, 0.0, p.mass_B)):
            line_density, length = p.rho * p.area[link], self.element_lengths[link]
            mass, stiffness, gyroscopic = np.zeros((3, 3 * n + 3, 3 * n + 3))
            for element in range(n):
                rows = slice(3 * element, 3 * element + 6)
                mass[rows, rows] += element_mass(line_density, length)  # (4.32)
                stiffness[rows, rows] += element_stiffness(p.E, p.area[link], p.inertia[link], length)  # (4.33)
                gyroscopic[rows, rows] += element_gyroscopic(line_density, length)  # (4.34), (4.35)
            u, w = 3 * n, 3 * n + 1
            mass[[u, w], [u, w]] += tip_mass
            gyroscopic[[u, w], [w, u]] += [-tip_mass, tip_mass]
            matrices.append((mass, stiffness, gyroscopic))
        return matrices

    def motion(self, theta: ArrayLike) -> tuple[LinkMotion, LinkMotion, LinkMotion]:
        """Rigid-body motion of crank, coupler and follower at crank angles `theta` (rad)."""
        p, theta1 = self.parameters, as_angles(theta)
        place = positions(theta1, p)
        theta2, theta3 = place["theta2_rad"], place["theta3_rad"]
        rate = rates(theta1, theta2, theta3, p)
        zero, a_a = np.zeros_like(theta1), p.a * p.omega1**2
        at_rest = np.zeros((theta1.size, 2))
        at_a = np.stack([-a_a * np.cos(theta2 - theta1), a_a * np.sin(theta2 - theta1)], axis=1)  # (6.47), erratum
        return (
            LinkMotion(theta1, np.full_like(theta1, p.omega1), zero, at_rest),
            LinkMotion(theta2, rate["omega2_rad_s"], rate["alpha2_rad_s2"], at_a),
            LinkMotion(theta3, rate["omega3_rad_s"], rate["alpha3_rad_s2"], at_rest),
        )

    @cached_property
    def _links(self) -> list[tuple[Array, list[tuple[int, int]]]]:
        """Constant part of each link's P, and (u row in the link, X column in the model) of its joints."""
        column = {label: i for i, label in enumerate(self.dof_labels)}
        joints_of_link = ({1.0: "A"}, {0.0: "A", 1.0: "B"}, {1.0: "B"})
        links = []
        for link, ends in zip(LINKS, joints_of_link, strict=True):
            constant = np.zeros((3 * self.elements + 3, self.size))
            joints = []
            for node in range(self.elements + 1):
                s = round(node / self.elements, 12)
                for place, kind in enumerate(("u", "w", "phi")):
                    if (link, s, kind) in column:
                        constant[3 * node + place, column[link, s, kind]] = 1.0
                if s in ends:
                    joints.append((3 * node, column[ends[s], "X"]))
            links.append((constant, joints))
        return links

    def transformations(self, theta: ArrayLike) -> list[LinkTransformation]:
        """P, P' and P'' of crank, coupler and follower at crank angles `theta` (rad), (4.40)-(4.43)."""
        answer = []
        for (constant, joints), motion in zip(self._links, self.motion(theta), strict=True):
            cos, sin = np.cos(motion.angle), np.sin(motion.angle)
            turn = np.stack([cos, sin, -sin, cos], axis=1).reshape(-1, 2, 2)  # [T]^T of (7.3)
            slope = np.stack([-sin, cos, -cos, -sin], axis=1).reshape(-1, 2, 2)  # its derivative by the angle
            omega, alpha = motion.omega[:, None, None], motion.alpha[:, None, None]
            value = np.repeat(constant[None], len(cos), axis=0)
            rate, second = np.zeros((2, *value.shape))
            for u, x in joints:
                value[:, u : u + 2, x : x + 2] = turn
                rate[:, u : u + 2, x : x + 2] = omega * slope  # (7.4)
                second[:, u : u + 2, x : x + 2] = alpha * slope - omega**2 * turn  # (7.5)
            answer.append(LinkTransformation(value, rate, second))
        return answer

    def mass_stiffness(self, theta: ArrayLike) -> tuple[Array, Array]:
        """M (4.57) and K (4.58), each of shape ``(angles, dofs, dofs)``; SI units."""
        total_mass: Array | float = 0.0
        total_stiffness: Array | float = 0.0
        for (mass, stiffness, _), tr in zip(self.link_matrices, self.transformations(theta), strict=True):
            transposed = tr.value.swapaxes(1, 2)
            total_mass = total_mass + transposed @ mass @ tr.value  # (4.47)
            total_stiffness = total_stiffness + transposed @ stiffness @ tr.value  # (4.48)
        return np.asarray(total_mass), np.asarray(total_stiffness)

    def coupling(self, theta: ArrayLike) -> Coupling:
        """Matrices of (4.66) besides M and K at crank angles `theta` (rad)."""
        md, mv, mdd, mdv, ma = np.zeros((5, np.size(theta), self.size, self.size))
        links = zip(self.link_matrices, self.motion(theta), self.transformations(theta), strict=True)
        for (mass, _, gyroscopic), motion, tr in links:
            omega, alpha = motion.omega[:, None, None], motion.alpha[:, None, None]
            transposed = tr.value.swapaxes(1, 2)
            mass_v = omega * gyroscopic  # (4.29)
            mass_a = alpha * gyroscopic - omega**2 * mass  # (4.30)
            md += transposed @ mass @ tr.rate  # (4.52), (4.59)
            mv += transposed @ mass_v @ tr.value  # (4.53), (4.60)
            mdd += transposed @ mass @ tr.second  # (4.49), (4.61)
            mdv += transposed @ mass_v @ tr.rate  # (4.50), (4.62)
            ma += transposed @ mass_a @ tr.value  # (4.51), (4.63)
        return Coupling(md, mv, mdd, mdv, ma)

    def rigid_acceleration(self, theta: ArrayLike) -> list[Array]:
        """Rigid-body acceleration of each link's nodes in its frame (m/s^2, rad/s^2), shape ``(angles, link dofs)``."""
        x = np.linspace(0.0, 1.0, self.elements + 1)
        answer = []
        for length, motion in zip(self.parameters.lengths, self.motion(theta), strict=True):
            nodes = np.empty((len(motion.angle), self.elements + 1, 3))
            nodes[..., 0] = motion.start[:, :1] - motion.omega[:, None] ** 2 * length * x
            nodes[..., 1] = motion.start[:, 1:] + motion.alpha[:, None] * length * x
            nodes[..., 2] = motion.alpha[:, None]
            answer.append(nodes.reshape(len(motion.angle), -1))
        return answer

    def load(self, theta: ArrayLike) -> Array:
        """Load f = -P^T m a_rigid at crank angles `theta` (rad), (4.45), shape ``(angles, dofs)`` (N, N m)."""
        total = np.zeros((np.size(theta), self.size))
        links = zip(self.link_matrices, self.transformations(theta), self.rigid_acceleration(theta), strict=True)
        for (mass, _, _), tr, rigid in links:
            total -= np.einsum("tij,ti->tj", tr.value, rigid @ mass)
        return total

    def modes(self, theta: ArrayLike, count: int | None = None) -> tuple[Array, Array]:
        """Natural frequencies and modes (E.2) of the linkage held at crank angles `theta` (rad).

        Parameters
        ----------
        theta
            Crank angles (rad), shape ``(angles,)``.
        count
            Modes wanted, lowest first; all of them when left out.

        Returns
        -------
        omega : ndarray
            Angular frequencies (rad/s), ascending, shape ``(angles, count)``.
        shapes : ndarray
            Modes as columns, orthonormal by M (E.7), shape ``(angles, dofs, count)``.
        """
        return modes_of(*self.mass_stiffness(theta), count)

    def frequencies(self, theta: ArrayLike) -> Array:
        """Natural frequencies (Hz), ascending, of the linkage held at crank angles `theta` (rad)."""
        return self.modes(theta)[0] / (2 * np.pi)


def turning_strain(model: NineElementModel, theta: ArrayLike) -> Array:
    """K^-1 P^T k P' at crank angles `theta` (rad), shape ``(angles, dofs, dofs)`` (1/s).

    Links are strained at the rate of q' plus this times q, as they turn against the coordinates of the pins.
    """
    links = zip(model.link_matrices, model.transformations(theta), strict=True)
    forces = sum(tr.value.swapaxes(1, 2) @ stiffness @ tr.rate for (_, stiffness, _), tr in links)
    return np.asarray(np.linalg.solve(model.mass_stiffness(theta)[1], forces))


def modes_of(mass: Array, stiffness: Array, count: int | None = None) -> tuple[Array, Array]:
    """Modes of ``(K - omega^2 M) phi = 0`` (E.2) for a stack of matrices; see `NineElementModel.modes`.

    K takes the place that M usually has in the reduction to one symmetric matrix: the eigenvalues are then 1/omega^2
    and the lowest modes come out with full precision although the axial ones are a thousand times faster.
    """
    angles, size = mass.shape[:2]
    count = size if count is None else count
    omega, shapes = np.empty((angles, count)), np.empty((angles, size, count))
    for i in range(angles):
        values, vectors = eigh(mass[i], stiffness[i], subset_by_index=(size - count, size - 1))
        values, vectors = values[::-1], vectors[:, ::-1]
        omega[i] = 1 / np.sqrt(values)
        shapes[i] = vectors / np.sqrt(values)  # phi^T K phi = 1 becomes (E.7)
    return omega, shapes
