"""Members that are reduced as strings: what their coordinates do to the elongation of all their elements together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.beams.nonlinear_stretching import Stretching
from fenics_mech.beams.span import outside

if TYPE_CHECKING:
    from fenics_mech.beams.reduction import Reduction


@dataclass(frozen=True, eq=False)
class Strings:
    """The members that are reduced, and the elements of all others one by one.

    Parameters
    ----------
    of_element
        String of each element, ``(elements,)``.
    coordinates
        The links' coordinates of each string, ``(strings, n)``; short ones are filled up with 0.
    shape
        Nodal dofs of each element by the coordinates of its string, ``(elements, 6, n)``; 0 where filled up.
    """

    of_element: Index
    coordinates: Index
    shape: Array

    @classmethod
    def of(cls, reduction: Reduction) -> Strings:
        """Find the strings of reduced links."""
        whole = outside(reduction.mesh, reduction.spans)
        dofs, modes = element_dofs(reduction.mesh), len(reduction.kept) + np.arange(len(reduction.mode_member))
        strings = [(np.array([e]), reduction.place[dofs[e]]) for e in np.flatnonzero(whole)]
        for span in reduction.spans:
            mine = modes[reduction.mode_member == span.member]
            strings.append((span.cells, np.append(reduction.place[span.ends], mine)))
        of_element = np.empty(len(dofs), dtype=np.int64)
        coordinates = np.zeros((len(strings), max(len(c) for _, c in strings)), dtype=np.int64)
        shape = np.zeros((len(dofs), 6, coordinates.shape[1]))
        for i, (elements, mine) in enumerate(strings):
            of_element[elements], coordinates[i, : len(mine)] = i, mine
            rows = reduction.shape[dofs[elements].ravel()][:, mine].toarray()
            shape[elements, :, : len(mine)] = rows.reshape(-1, 6, len(mine))
        return cls(of_element, coordinates, shape)

    def stretching(self, of_elements: Stretching) -> Stretching:
        """Elongation of the strings by that of their elements."""
        line = np.einsum("ei,ein->en", of_elements.line, self.shape)
        bow = self.weighted(of_elements.bow, np.ones((1, len(line))))[0]
        whole = np.zeros(self.coordinates.shape)
        np.add.at(whole, self.of_element, line)
        return Stretching(whole, bow)

    def weighted(self, bow: Array, weight: Array) -> Array:
        """Sum the elements' matrices ``(elements, 6, 6)`` with weights ``(angles, elements)`` over each string.

        Returns
        -------
        numpy.ndarray
            ``(angles, strings, n, n)``.
        """
        blocks = self.shape.transpose(0, 2, 1) @ bow @ self.shape
        count, n = self.coordinates.shape
        found = np.zeros((len(weight), count, n * n))
        for i in range(count):
            mine = self.of_element == i
            found[:, i] = weight[:, mine] @ blocks[mine].reshape(-1, n * n)
        return found.reshape(len(weight), count, n, n)
