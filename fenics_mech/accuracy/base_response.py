"""A response that corrected ones are compared with, with all its nodes or with few."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from fenics_mech._arrays import Array
from fenics_mech.accuracy.corrected_response import CorrectedResponse, WithoutMesh
from fenics_mech.accuracy.mesh_residual import moved_by_gaps
from fenics_mech.accuracy.missed_resonances import missed_vibrations
from fenics_mech.accuracy.quantities import Quantities
from fenics_mech.effects import UNLOADED
from fenics_mech.mechanism import System
from fenics_mech.response.solution import Solution


@dataclass(frozen=True)
class Compared:
    """A response and what it comes to.

    Parameters
    ----------
    solution
        The response.
    system
        Its mechanism, as forces act on it.
    base
        Its quantities.
    """

    solution: Solution
    system: System
    base: Quantities

    @classmethod
    def of(cls, solution: Solution, system: System) -> Compared:
        """Recover the quantities of a response.

        Parameters
        ----------
        solution, system
            The response, and its mechanism as forces act on it.
        """
        return cls(solution, system, Quantities.of(solution.scene, system, solution.response.undamped))

    @property
    def on_few_nodes(self) -> Compared:
        """The same response on few nodes, where the solution has them; else itself."""
        few = self.solution.on_few_nodes
        return self if few is self.solution else Compared.of(few, few.system)

    def change(self, source: str, without: CorrectedResponse) -> dict[str, Array]:
        """Give the largest change of each quantity by a correction.

        Parameters
        ----------
        source
            Source of error that the corrected response is without.
        without
            That response.
        """
        solution, system = self.solution, self.system
        if without.response.displacement is solution.response.displacement and without.loads is UNLOADED:
            return {}
        change = Quantities.of(solution.scene, system, without.response.undamped, without.loads) - self.base
        if isinstance(without, WithoutMesh):
            change = change.times(1 / without.share)
        if source == "mesh" and system.transformation.constraints.contacts:
            change = change.with_nodes(system, moved_by_gaps(system, solution.response.undamped))
        return change.largest

    @cached_property
    def missed(self) -> dict[str, dict[str, Array]]:
        """What vibrations that it may miss change of each quantity at most, by source of error."""
        found = {}
        for source, vibrating, share in missed_vibrations(self.solution):
            change = Quantities.of(self.solution.scene, self.system, vibrating.undamped) - self.base
            found[source] = change.times(1 / share).largest
        return found
