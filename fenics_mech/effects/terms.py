"""What effects add to the equation of motion of the links, in the links' own axes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np

from fenics_mech._arrays import Array, Index, summed
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.effects.given_axial_forces import AxialForces, AxialStiffness
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams
    from fenics_mech.beams.mesh import BeamMesh
    from fenics_mech.effects.joint_frames import LawForces
    from fenics_mech.effects.nonlinear_law import ArcLength
    from fenics_mech.effects.rotation_forces import RotationForces


def _no_tension() -> NoReturn:
    raise AssertionError("the axial forces are asked for while they are being found")


@dataclass(frozen=True)
class Situation:
    """What an effect may look at.

    Parameters
    ----------
    scene, beams, motion
        The scene, its links' matrices and its rigid motion.
    tension
        Gives the axial forces of the elements from loads and rigid motion.
    uneven
        Gives of these what changes along each element alone (N), ``(angles, elements)``; see `AxialForces.slope`.
    """

    scene: Scene
    beams: Beams
    motion: Motion
    tension: Callable[[], AxialForces] = _no_tension
    uneven: Callable[[], Array] = _no_tension


def in_links(motion: Motion, vectors: Array, turned: float = 0.0) -> Array:
    """Components of vectors of the fixed frame, ``(..., 2)``, in the axes of every link turned by an angle further.

    Parameters
    ----------
    motion
        The rigid motion, for the angles of the links.
    vectors
        Components along X and Y.
    turned
        The angle (rad), the same for all links.

    Returns
    -------
    numpy.ndarray
        ``(angles, links, ..., 2)``, by the transpose of (7.3).
    """
    angle = (motion.angle + turned).reshape(*motion.angle.shape, *(1,) * (vectors.ndim - 1))
    c, s, x, y = np.cos(angle), np.sin(angle), vectors[..., 0], vectors[..., 1]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


@dataclass(frozen=True)
class Entries:
    """A matrix over the nodal dofs, in link axes, that may change with the drive angle.

    Parameters
    ----------
    rows, columns
        Place of each entry, ``(entries,)``; entries at one place add up.
    values
        ``(angles, entries)``, or ``(1, entries)`` where they do not change.
    """

    rows: Index
    columns: Index
    values: Array

    @classmethod
    def of_elements(cls, mesh: BeamMesh, blocks: Array) -> Entries:
        """Give the matrix of element blocks in link axes, ``(angles or 1, elements, 6, 6)``.

        Parameters
        ----------
        mesh
            The mesh.
        blocks
            Block of each element over the dofs of its two nodes.
        """
        return cls.of_blocks(element_dofs(mesh), blocks)

    @classmethod
    def of_blocks(cls, dofs: Index, blocks: Array) -> Entries:
        """Give the matrix of blocks ``(angles or 1, elements, n, n)`` on `dofs`, ``(elements, n)``.

        Parameters
        ----------
        dofs
            Nodal dofs of each element.
        blocks
            Block of each element over its dofs.
        """
        rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
        return cls(rows.ravel(), columns.ravel(), blocks.reshape(len(blocks), -1))

    def part(self, angles: slice) -> Entries:
        """Give the matrix at some of the angles."""
        return self if len(self.values) == 1 else replace(self, values=self.values[angles])

    def times(self, vectors: Array) -> Array:
        """Product with one vector at each angle, ``(angles, nodal dofs)``.

        Parameters
        ----------
        vectors
            The vectors, ``(angles, nodal dofs)``.
        """
        return summed(self.values * vectors[:, self.columns], self.rows, vectors.shape[1])

    def dense(self, size: int) -> Array:
        """The matrix at all angles, ``(angles or 1, size, size)``.

        Parameters
        ----------
        size
            Number of nodal dofs.
        """
        return summed(self.values, self.rows * size + self.columns, size**2).reshape(-1, size, size)


@dataclass(frozen=True)
class LoadInElement:
    """A load at a place inside an element.

    Parameters
    ----------
    element, place
        The element, and the place 0..1 in it.
    force
        Along the member's axis, along its normal (N), and moment (N m), ``(angles, 3)``.
    """

    element: int
    place: float
    force: Array


class _Sum:
    """A record whose parts add up one by one; a part that is None adds nothing."""

    def __add__(self, other: Self) -> Self:
        """Give the sum of both records."""
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        return type(self)(**{name: _sum(getattr(self, name), getattr(other, name)) for name in names})


def _sum(a: Any, b: Any) -> Any:
    if a is None or b is None:
        return b if a is None else a
    return a or b if isinstance(a, bool) else a + b


@dataclass(frozen=True)
class Loads(_Sum):
    """Loads on the links.

    Parameters
    ----------
    force
        Loads on the nodal dofs, ``(angles, nodal dofs)`` (N, N m).
    line
        Loads spread along the elements, linear in each, in its member's axes: along the axis at its first and second
        node, then along the normal, ``(angles, elements, 4)`` (N/m).
    ends
        Loads on the elements' ends, in their members' axes, ``(angles, elements, 6)`` (N, N m): they are inside the
        elements, and no load of the nodes.
    inside
        Of the loads on the elements' ends, those that act at a place inside an element, and where.
    """

    force: Array | None = None
    line: Array | None = None
    ends: Array | None = None
    inside: tuple[LoadInElement, ...] = ()

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._arrays())

    def turned(self) -> Loads:
        """Give the loads turned by a quarter clockwise: the work that they do on v as a link turns by 1 rad.

        Moments are taken for couples. Of a force on an arm of a rigid link, the turn of the arm is left out.
        """
        force = None if self.force is None else quarter_back(self.force, (len(self.force), -1, 3))
        ends = None if self.ends is None else quarter_back(self.ends, (*self.ends.shape[:2], 2, 3))
        line = None if self.line is None else np.concatenate([self.line[..., 2:], -self.line[..., :2]], axis=-1)
        return Loads(force, line, ends)

    def columns(self) -> Array:
        """Put the loads into one array, ``(angles, numbers)``."""
        return np.concatenate([part.reshape(len(part), -1) for part in self._arrays().values()], axis=1)

    def of_columns(self, columns: Array) -> Loads:
        """Take loads of the same kinds as these out of such an array."""
        arrays = self._arrays()
        ends = np.cumsum([part[0].size for part in arrays.values()])[:-1]
        parts = zip(arrays.items(), np.split(columns, ends, axis=1))
        found: dict[str, Any] = {name: part.reshape(like.shape) for (name, like), part in parts}
        return Loads(**found)

    def part(self, angles: slice) -> Loads:
        """Take the loads at some of the angles."""
        found: dict[str, Any] = {name: part[angles] for name, part in self._arrays().items()}
        return Loads(**found)

    def _arrays(self) -> dict[str, Array]:
        return {name: part for name in ("force", "line", "ends") if (part := getattr(self, name)) is not None}


def quarter_back(forces: Array, shape: tuple[int, ...]) -> Array:
    """Turn forces along two axes, beside a moment in each, by a quarter clockwise; they are an array of that shape.

    Moments do no work in it.

    Parameters
    ----------
    forces
        Forces and moments, in any shape.
    shape
        The shape whose last axis is force, force, moment.
    """
    x, y, _ = np.moveaxis(forces.reshape(shape), -1, 0)
    return np.stack([y, -x, np.zeros_like(x)], axis=-1).reshape(forces.shape)


@dataclass(frozen=True)
class AddedMatrices(_Sum):
    """Matrices over the nodal dofs that are no elements'.

    Parameters
    ----------
    stiffness, damping
        Those of springs and dampers (N/m ..., N s/m ...).
    follower
        Stiffness of loads that turn with the links, which is not symmetric.
    convective
        Stiffness from the rates of the rigid motion, of dampers whose ends move. It counts where the motion is coupled,
        and is not symmetric.
    """

    stiffness: tuple[Entries, ...] = ()
    damping: tuple[Entries, ...] = ()
    follower: tuple[Entries, ...] = ()
    convective: tuple[Entries, ...] = ()


@dataclass(frozen=True)
class ProportionalDamping(_Sum):
    """Damping in proportion to the links' mass and stiffness.

    Parameters
    ----------
    external, relative
        Drag per mass on the absolute velocity, and on that relative to the links' own axes (1/s).
    material
        Retardation time of the material (s): the force goes with the strain's rate.
    """

    external: float = 0.0
    relative: float = 0.0
    material: float = 0.0

    @property
    def drag(self) -> float:
        """Drag per mass on the rate of the elastic displacement (1/s)."""
        return self.external + self.relative


@dataclass(frozen=True)
class Terms(_Sum):
    """What effects add; every part may be missing, and a part that is missing costs nothing.

    Parameters
    ----------
    coupled
        Whether the elastic motion feels the turning of its link's axes (P', P'', Coriolis, centrifugal, Euler).
    loads
        Loads on the links.
    matrices
        Matrices of springs, dampers and loads that turn with the links.
    damping
        Damping in proportion to mass and stiffness.
    acceleration
        Acceleration that acts like that of the rigid motion: minus gravity (m/s^2), ``(angles, nodal dofs)``.
    stiffening
        Stiffness of the mean axial forces of the elements, where they are given.
    uneven
        Stiffness of what axial forces that are given change along the elements.
    law
        A nonlinear force of the elements.
    rotation_forces
        Beside the linear parts above, where a law makes slopes the sines of rotations: what acts on rotations.
    joint_laws
        Forces of joint laws, known for the motion at hand.
    """

    coupled: bool = False
    loads: Loads = Loads()
    matrices: AddedMatrices = AddedMatrices()
    damping: ProportionalDamping = ProportionalDamping()
    acceleration: Array | None = None
    stiffening: AxialStiffness | None = None
    uneven: tuple[AxialStiffness, ...] = ()
    law: ArcLength | None = None
    rotation_forces: tuple[RotationForces, ...] = ()
    joint_laws: tuple[LawForces, ...] = ()

    @property
    def axial_stiffness(self) -> tuple[Array, ...]:
        """Blocks of the elements by axial forces that are given, in link axes, ``(angles, elements, 6, 6)`` each."""
        even = () if self.stiffening is None else (self.stiffening,)
        return tuple(part.blocks for part in (*even, *self.uneven))


NOTHING, UNLOADED = Terms(), Loads()
