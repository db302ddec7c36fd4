"""What acts on the rotation of an axis that turns far, or turns with it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array, Index, summed
from fenics_mech.effects.large_rotations import EFFECT

COUNT, SINES = 3, slice(1, 3)  # of the dofs of a force, and which of them are sines of rotations


def of_sines(effects: Collection[str]) -> bool:
    """Whether slopes w' are the sines of rotations, and not small rotations themselves.

    Parameters
    ----------
    effects
        Names of the effects that act.
    """
    return EFFECT.name in effects


def rotated(slope: Array) -> Array:
    """Give the rotations of which w' are the sines; no numbers from a right angle on.

    Parameters
    ----------
    slope
        Slopes w' of the axes.
    """
    with np.errstate(invalid="ignore"):
        return np.asarray(np.arcsin(slope))


def cosine(slope: Array) -> Array:
    """Give the cosines of these rotations.

    Parameters
    ----------
    slope
        Slopes w' of the axes.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.sqrt(1 - slope**2))


@dataclass(frozen=True, eq=False)
class RotationForces:
    """Forces on rotations, and forces that turn with them, less what linear theory has of both.

    With exact strains the slope ``b = w'`` is the sine of the rotation ``phi``. The couple ``k phi + d phi' - M`` does
    its work on phi, so that the force on b is the couple over the cosine c of phi; linear theory takes phi for b. A
    force F that turns with the axis becomes ``c F + b Q F``, with Q a quarter turn; linear theory takes c for 1.

    Each force acts on one dof. It has a couple that acts on one rotation, i, by another or the same one, j; or its F
    turns with the rotation j.

    Parameters
    ----------
    dofs
        The dof that it acts on, and the rotations i and j: nodal dofs, or the links' coordinates that move these,
        ``(forces, n)``.
    given
        M (N m), k (N m/rad), d (N m s/rad) and F (N), ``(angles or 1, 4, forces)``.
    shape
        The three dofs by those that are stated, ``(forces, 3, n)``.
    """

    dofs: Index
    given: Array
    shape: Array

    @classmethod
    def of_couples(
        cls, rotations: Index, moment: Array, stiffness: Array | float = 0.0, damping: Array | float = 0.0
    ) -> RotationForces:
        """Give the couples ``K phi + D phi' - M`` on some rotations.

        Parameters
        ----------
        rotations
            Their nodal dofs, ``(m,)``.
        moment
            M, ``(angles, m)``.
        stiffness, damping
            K and D, ``(angles, m, m)``.
        """
        i, j = np.indices((len(rotations), len(rotations))).reshape(2, -1)
        given = np.zeros((4, len(moment), *2 * (len(rotations),)))
        given[0] = moment[:, :, None] * np.eye(len(rotations))
        given[1], given[2] = stiffness, damping
        return cls._of_nodes(rotations[np.stack([i, i, j], axis=-1)], given.reshape(4, -1, len(i)))

    @classmethod
    def turning(cls, dofs: Index, force: Array) -> RotationForces:
        """Give a force in link axes, ``(angles, 2)``, that turns with the last of a node's three dofs.

        Parameters
        ----------
        dofs
            The three dofs of the node.
        force
            The force (N).
        """
        given = np.zeros((4, *force.shape))
        given[3] = force
        return cls._of_nodes(np.stack([dofs[:2], dofs[[2, 2]], dofs[[2, 2]]], axis=-1), given)

    @classmethod
    def _of_nodes(cls, dofs: Index, given: Array) -> RotationForces:
        return cls(dofs, given.swapaxes(0, 1), np.broadcast_to(np.eye(COUNT), (len(dofs), COUNT, COUNT)))

    @classmethod
    def joined(cls, parts: Sequence[RotationForces]) -> RotationForces:
        """Give several together.

        Parameters
        ----------
        parts
            Forces at the same angles, each on dofs of the same kind.
        """
        dofs, given, shape = zip(*((part.dofs, part.given, part.shape) for part in parts))
        return cls(np.concatenate(dofs), np.concatenate(given, axis=2), np.concatenate(shape))

    def by(self, coordinates: Index, shape: Array) -> RotationForces:
        """Give them by the coordinates that move their dofs, which are ``shape z``, ``(forces, 3, n)``.

        Parameters
        ----------
        coordinates
            Coordinates that move the dofs of each force, ``(forces, n)``.
        shape
            The dofs by these coordinates.
        """
        return replace(self, dofs=coordinates, shape=shape)

    def scaled(self, share: float) -> RotationForces:
        """Give them with a share of what loads them, M and F.

        Parameters
        ----------
        share
            The factor on M and F.
        """
        return replace(self, given=self.given * np.array([share, 1.0, 1.0, share])[:, None])

    def force(self, v: Array, rate: Array) -> Array:
        """Forces from v and v', on the side of the elastic ones, ``(angles, forces, n)``.

        Parameters
        ----------
        v, rate
            Displacement and velocity over what `dofs` counts, nodal dofs or links' coordinates, ``(angles, ...)``.
        """
        return self._values(v, rate)[0][..., None] * self.shape[:, 0]

    def on_nodes(self, v: Array, rate: Array) -> Array:
        """Sum those of nodal dofs, ``(angles, nodal dofs)``.

        Parameters
        ----------
        v, rate
            Displacement and velocity in link axes, ``(angles, nodal dofs)``.
        """
        forces = self.force(v, rate)
        return summed(forces.reshape(len(forces), -1), self.dofs.ravel(), v.shape[1])

    def linearised(self, v: Array, rate: Array) -> tuple[Array, Array, Array]:
        """Force about v and v', ``constant + by_v v + by_rate v'``.

        Parameters
        ----------
        v, rate
            Displacement and velocity over what `dofs` counts, nodal dofs or links' coordinates, ``(angles, ...)``.

        Returns
        -------
        tuple
            The constant ``(angles, forces, n)``, and two matrices ``(angles, forces, n, n)``.
        """
        value, by_sines, by_speed = self._values(v, rate)
        sines, out = self.shape[:, SINES], self.shape[:, 0]
        by_v, by_rate = np.einsum("tfs,fsn->tfn", by_sines, sines), by_speed[..., None] * sines[:, 1]
        constant = value - np.sum(by_v * v[:, self.dofs] + by_rate * rate[:, self.dofs], axis=-1)
        matrix_v, matrix_rate = (out[:, :, None] * row[..., None, :] for row in (by_v, by_rate))
        return constant[..., None] * out, matrix_v, matrix_rate

    def _values(self, v: Array, rate: Array) -> tuple[Array, Array, Array]:
        """Each force ``(angles, forces)``, and its derivatives by both sines, ``(..., 2)``, and by the rate of j."""
        moment, stiffness, damping, turning = np.moveaxis(self.given, 1, 0)
        b = np.einsum("fsn,tfn->tfs", self.shape[:, SINES], v[:, self.dofs])
        speed = np.einsum("fn,tfn->tf", self.shape[:, 2], rate[:, self.dofs])
        (b_i, b_j), (c_i, c_j) = np.moveaxis(b, -1, 0), np.moveaxis(cosine(b), -1, 0)
        couple = stiffness * rotated(b_j) + damping * speed / c_j - moment
        value = couple / c_i - (stiffness * b_j + damping * speed - moment) + turning * (1 - c_j)
        by_j = (stiffness / c_j + damping * speed * b_j / c_j**3) / c_i - stiffness + turning * b_j / c_j
        return value, np.stack([couple * b_i / c_i**3, by_j], axis=-1), damping / (c_i * c_j) - damping
