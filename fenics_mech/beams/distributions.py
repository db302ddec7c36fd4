"""Properties of the sections along the elements: constant in each, or polynomials where sections vary."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError

if TYPE_CHECKING:
    from fenics_mech.beams.layout import Layout
    from fenics_mech.beams.mesh import BeamMesh

DEGREE = 4  # of the polynomials that stand for a section that varies


@dataclass(frozen=True)
class Distribution:
    """A property of the sections along the elements."""

    coefficient: Any  # the property as UFL coefficient
    mean: Array  # its mean over each element, (elements,)
    # Coefficients of the powers of the place 0..1 in each element, (elements, powers): `DEGREE` + 1 of them, or one
    # where no section varies. The same polynomials stand in the coefficient.
    powers: Array

    @classmethod
    def constant(cls, layout: Layout, by_element: Array) -> Distribution:
        """Give a property with one value per element, ``(elements,)``."""
        return cls(layout.coefficient(by_element), by_element, by_element[:, None])

    @property
    def varies(self) -> bool:
        """Whether it changes along elements."""
        return self.powers.shape[-1] > 1


def along_elements(layout: Layout, properties: Callable[[str, Array], Array], varies: bool) -> tuple[Distribution, ...]:
    """Properties of the members as polynomials in each element, constant ones where no section varies."""
    # properties (properties, places)
    return (_varying if varies else _constant)(layout, properties)


def _constant(layout: Layout, properties: Callable[[str, Array], Array]) -> tuple[Distribution, ...]:
    """Give properties with one value per element."""
    mesh = layout.mesh
    values = np.array([properties(label, np.zeros(1)) for label in mesh.members])[mesh.cell_member]
    return tuple(Distribution.constant(layout, column) for column in values[..., 0].T)


def _varying(layout: Layout, properties: Callable[[str, Array], Array]) -> tuple[Distribution, ...]:
    """Give polynomials of degree `DEGREE`."""
    # They are interpolated in a discontinuous Lagrange space, so that UFL chooses a quadrature that is exact for
    # them: degree 2 more than theirs in bending, 6 more in the mass.
    import ufl  # noqa: PLC0415  (slow to import, and few sections vary)

    from fenics_mech import _fenicsx  # noqa: PLC0415

    mesh = layout.mesh
    count = len(properties(mesh.members[0], np.zeros(1)))
    space = _fenicsx.broken_space(mesh.mesh, (DEGREE,) * count)
    function = _fenicsx.fem.Function(space)
    powers = np.empty((len(mesh.cell), count, DEGREE + 1))
    for part in range(count):
        dofs, points = _fenicsx.cell_dofs(space, part)
        xi = np.where(mesh.cell_flipped[:, None], 1 - points, points)  # (elements, points)
        s = (mesh.cell_start[:, None] + mesh.cell_length[:, None] * xi) / mesh.member_length[mesh.cell_member, None]
        values = np.empty_like(s)
        for i, label in enumerate(mesh.members):
            here = mesh.cell_member == i
            values[here] = properties(label, np.clip(s[here].ravel(), 0, 1))[part].reshape(-1, DEGREE + 1)
        function.x.array[dofs[mesh.cell]] = values
        powers[:, part] = np.linalg.solve(
            np.vander(xi.ravel(), DEGREE + 1, True).reshape(*xi.shape, -1), values[..., None]
        )[..., 0]
    _refuse_negative(mesh, powers)
    mean = 1 / np.arange(1, DEGREE + 2)  # of each power over 0..1
    return tuple(Distribution(part, p @ mean, p) for part, p in zip(ufl.split(function), powers.transpose(1, 0, 2)))


def _refuse_negative(mesh: BeamMesh, powers: Array) -> None:
    """Raise where a polynomial through positive values is negative between them: the section varies too fast for it."""
    between = np.vander(np.linspace(0, 1, 41), DEGREE + 1, increasing=True)
    bad = (powers @ between.T).min(axis=(1, 2)) <= 0
    if bad.any():
        element = int(np.argmax(bad))
        i = mesh.cell_member[element]
        raise SceneError(
            f"the section varies too fast for the element at {mesh.cell_start[element] / mesh.member_length[i]:.4g}",
            place=f"member {mesh.members[i]}",
            hint="Use more elements",
        )
