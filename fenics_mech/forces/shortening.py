"""How bending shortens members whose axial forces are given: the motion of the links that goes with it.

Geometric stiffness takes the axial forces N of loads and rigid motion as given. Each element is shorter by
``s = v^T bow v/2``, and N does work on it. In the mechanism that work is done by the loads and the inertia that N
balances, on the displacement u that the shortening causes. By Betti's theorem ``sum of N s = -F^T u``, with the forces
F on the nodes, if u is the elastic answer of the links to elements that are too short by s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import SuperLU, splu

from fenics_mech._arrays import Array
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.beams.nonlinear_stretching import half_square_in_time
from fenics_mech.effects import NOTHING
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism import System
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class Shortening:
    """Displacement u of the nodes by the shortening of bent members, of second order in the elastic displacement.

    Parameters
    ----------
    system
        The mechanism, with geometric stiffness.
    jets
        Elastic displacement v in link axes and two time derivatives, each ``(angles, nodal dofs)``.
    """

    system: System
    jets: tuple[Array, Array, Array]

    @classmethod
    def of(cls, scene: Scene, system: System, jets: tuple[Array, Array, Array]) -> Shortening | None:
        """Give it where axial forces that are given act on the bent axis.

        Parameters
        ----------
        scene
            The scene.
        system
            Its mechanism.
        jets
            Elastic displacement v in link axes and its two time derivatives, ``(angles, nodal dofs)`` each.
        """
        if system.terms.stiffening is None:
            return None
        return cls(system, jets)

    @cached_property
    def in_time(self) -> tuple[Array, Array, Array]:
        """Give u and its two time derivatives in link axes, each ``(angles, nodal dofs)``."""
        transformation, motion = self.system.transformation, self.system.motion
        lengths = half_square_in_time(self._pair, self.jets)
        zero, one, two = self._moved(lengths, (self.system.values, *transformation.derivatives(motion)))
        return zero, one, two

    def by_drive(self, unit: Motion, swung: Array) -> Array:
        """Change of u as one drive moves at unit rate and v changes by `swung`, ``(angles, nodal dofs)`` each.

        Parameters
        ----------
        unit
            Motion of the links at the same positions as one drive moves at unit rate.
        swung
            Rate of v in that motion, ``(angles, nodal dofs)``.
        """
        v, rate = self.jets[0], self.system.transformation.derivatives(unit)[0]
        return self._moved((self._pair(v, v) / 2, self._pair(swung, v)), (self.system.values, rate))[1]

    def by_velocity(self, change: Array) -> Array:
        """Change of the rate of u by a change of v', ``(angles, nodal dofs)`` each.

        Parameters
        ----------
        change
            Change of v' in link axes, ``(angles, nodal dofs)``.
        """
        return self._moved((self._pair(change, self.jets[0]),), (self.system.values,))[0]

    def _pair(self, a: Array, b: Array) -> Array:
        """``a^T bow b`` of each element (m), ``(angles, elements)``."""
        dofs = element_dofs(self.system.beams.mesh)
        return self.system.beams.stretching.bowed(a[:, dofs], b[:, dofs])

    def _moved(self, lengths: Sequence[Array], values: Sequence[Array]) -> list[Array]:
        """Give u and its derivatives from those of the shortenings and of P, by Leibniz' rule.

        In the links' coordinates ``u = P x`` leaves the stress ``k u + h``, which is in equilibrium: ``P^T (k u + h) =
        0``.
        """
        system, transformation = self.system, self.system.transformation
        found = [self._inside(length) for length in lengths]
        answers: list[Array] = []
        stresses: list[Array] = []
        for n, length in enumerate(lengths):
            u, right = (np.zeros((len(length), size)) for size in transformation.shape)
            for i in range(1, n + 1):
                u += math.comb(n, i) * transformation.forward(values[i], answers[n - i])
                right -= math.comb(n, i) * transformation.backward(values[i], stresses[n - i])
            forces = self._forces(length)
            right -= transformation.backward(values[0], forces + self._stress(u))
            answers.append(np.array([factor.solve(part) for factor, part in zip(self._factors, right)]))
            u += transformation.forward(values[0], answers[n])
            stresses.append(forces + self._stress(u))
            found[n] += system.on_nodes(u)
        return found

    def _stress(self, v: Array) -> Array:
        return np.asarray((self.system.link_stiffness @ v.T).T)

    def _forces(self, shorter: Array) -> Array:
        """Forces on the links' coordinates that would stretch the elements back, ``(angles, links' coordinates)``."""
        beams = self.system.beams
        pull = shorter * beams.rigidity.axial.mean / beams.mesh.cell_length
        nodal = self.system.assembled(pull[..., None] * beams.stretching.line)
        if beams.reduction is None:
            return nodal
        forces = np.asarray((beams.reduction.shape.T @ nodal.T).T)
        forces[:, len(beams.reduction.kept) :] = 0.0  # what stretches inside a member is in `_inside`
        return forces

    def _inside(self, shorter: Array) -> Array:
        """Displacement of the inner nodes of reduced members whose ends are held, ``(angles, nodal dofs)``."""
        beams = self.system.beams
        moved = np.zeros((len(shorter), self.system.transformation.height))
        if beams.reduction is None:
            return moved
        for span in beams.reduction.spans:
            flexible = beams.mesh.cell_length[span.cells] / beams.rigidity.axial.mean[span.cells]
            gone = shorter[:, span.cells]
            longer = gone.sum(axis=1, keepdims=True) * flexible / flexible.sum() - gone
            moved[:, span.inner] += np.cumsum(longer, axis=1)[:, :-1, None] * span.rotation[0]
        return moved

    @cached_property
    def _factors(self) -> list[SuperLU]:
        """Factors of the links' stiffness over the coordinates at every angle."""
        _, stiffness = replace(self.system, terms=NOTHING).held_matrices()
        return [splu(stiffness.at(k).tocsc()) for k in range(len(stiffness))]
