"""P(theta): from the mechanism's coordinates q to the links' nodal dofs, with its time derivatives.

It is [Tr] of (4.40)-(4.56). A revolute joint has two coordinates of its own, its displacements along the fixed X and
Y axes, which every link that it joins turns into its own axes; all other coordinates are nodal dofs of one link. A pin
on the ground has none, and a driven joint ties the rotations of its two bodies together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech.beams import BeamMesh
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
Index = NDArray[np.int64]
COMPONENTS = ("x", "y", "rotation")


@dataclass(frozen=True)
class Transformation:
    """The nonzeros of P: each is ``constant + cosine cos(phi) + sine sin(phi)``, phi its link's angle.

    Parameters
    ----------
    rows, columns
        Places of the nonzeros in row order, shape ``(nonzeros,)``.
    link
        Link that owns the row of each nonzero.
    constant, cosine, sine
        Coefficients of each nonzero.
    names
        Name of each coordinate q: "joint.X", "joint.Y", "joint.rotation", or "node.x", "node.y", "node.rotation".
    height
        Number of rows: nodal dofs of all links.
    """

    rows: Index
    columns: Index
    link: Index
    constant: Array
    cosine: Array
    sine: Array
    names: tuple[str, ...]
    height: int

    @property
    def shape(self) -> tuple[int, int]:
        """Nodal dofs by coordinates."""
        return self.height, len(self.names)

    def values(self, motion: Motion) -> Array:
        """Nonzeros of P at all angles, shape ``(angles, nonzeros)``."""
        phi = motion.angle[:, self.link]
        return self.constant + self.cosine * np.cos(phi) + self.sine * np.sin(phi)

    def derivatives(self, motion: Motion) -> tuple[Array, Array]:
        """Nonzeros of the first and second time derivative of P, each ``(angles, nonzeros)`` (1/s, 1/s^2)."""
        phi, omega, alpha = (array[:, self.link] for array in (motion.angle, motion.omega, motion.alpha))
        slope = self.sine * np.cos(phi) - self.cosine * np.sin(phi)  # (7.4)
        return omega * slope, alpha * slope - omega**2 * (self.cosine * np.cos(phi) + self.sine * np.sin(phi))  # (7.5)

    def forward(self, values: Array, q: Array) -> Array:
        """``P q`` at all angles: ``(angles, ..., coordinates)`` to ``(angles, ..., nodal dofs)``."""
        return _summed(values * q[..., self.columns], self.rows, self.height)

    def backward(self, values: Array, force: Array) -> Array:
        """``P^T force`` at all angles: ``(angles, ..., nodal dofs)`` to ``(angles, ..., coordinates)``."""
        return _summed(values * force[..., self.rows], self.columns, len(self.names))


def _summed(terms: Array, target: Index, size: int) -> Array:
    """Sum the last axis of `terms` over the entries that share a target."""
    collect = sp.csr_matrix((np.ones(len(target)), (target, np.arange(len(target)))), shape=(size, len(target)))
    flat = terms.reshape(-1, terms.shape[-1])
    return np.asarray(collect @ flat.T).T.reshape(*terms.shape[:-1], size)


def build_transformation(scene: Scene, mesh: BeamMesh) -> Transformation:
    """Lay out the coordinates of a scene's mechanism."""
    joint_of = {point: name for name, joint in scene.joints.items() for point in joint.connect}
    grounded = {name for name, joint in scene.joints.items() if any(p.startswith("ground.") for p in joint.connect)}
    columns: dict[str, int] = {}
    entries: list[tuple[int, int, int, float, float, float]] = []

    def column(name: str) -> int:
        return columns.setdefault(name, len(columns))

    for node, (name, link) in enumerate(zip(mesh.node_name, mesh.node_link)):
        row, joint = 3 * node, joint_of.get(name)
        if joint is None:
            entries += [(row + i, column(f"{name}.{c}"), link, 1.0, 0.0, 0.0) for i, c in enumerate(COMPONENTS[:2])]
        elif joint not in grounded:
            x, y = column(f"{joint}.X"), column(f"{joint}.Y")
            entries += [
                (row, x, link, 0.0, 1.0, 0.0),  # transpose of (7.3)
                (row, y, link, 0.0, 0.0, 1.0),
                (row + 1, x, link, 0.0, 0.0, -1.0),
                (row + 1, y, link, 0.0, 1.0, 0.0),
            ]
        if joint != scene.drive.joint:
            entries.append((row + 2, column(f"{name}.rotation"), link, 1.0, 0.0, 0.0))
        elif joint not in grounded:
            entries.append((row + 2, column(f"{joint}.rotation"), link, 1.0, 0.0, 0.0))
    table = np.array(sorted(entries))
    return Transformation(
        rows=table[:, 0].astype(np.int64),
        columns=table[:, 1].astype(np.int64),
        link=table[:, 2].astype(np.int64),
        constant=table[:, 3],
        cosine=table[:, 4],
        sine=table[:, 5],
        names=tuple(columns),
        height=3 * len(mesh.node_name),
    )
