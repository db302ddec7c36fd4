"""Torsion of a section of any shape, by the warping of its plane: a Poisson problem with free edges.

Source: Pilkey, Analysis and Design of Elastic Beams (2002), chapters 5 and 6; the shear centre is Trefftz's.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from fenics_mech import _fenicsx, _gmsh
from fenics_mech._arrays import Array
from fenics_mech._fenicsx import ufl
from fenics_mech._petsc import DIRECT, PETSc, configured, to_petsc
from fenics_mech.errors import SceneError

ACROSS = 12  # elements of the second degree across the shorter side of the box: a square's J is 4e-5 off
MOST = 20_000  # squares of elements in a long section
FLAT = 1e-12  # of the lesser extent squared: an area between corners that counts as none
Corners = tuple[tuple[float, float], ...]


class PolygonNumbers(NamedTuple):
    """Numbers of a polygon in the order of `SectionNumbers`."""

    area: float
    inertia: tuple[float, float]
    torsion: float
    corners: Array
    torsion_modulus: float | None
    turn: float
    shear_centre: tuple[float, float]


def polygon_numbers(outline: Corners, holes: tuple[Corners, ...] = ()) -> PolygonNumbers:
    """Compute the numbers of a polygon.

    With a twist of 1 per length the plane warps by w. The shear strains are dw/dy - z and dw/dz + y, and no stress acts
    on an edge: the integral of grad w . grad v is that of z dv/dy - y dv/dz for every v.

    Parameters
    ----------
    outline
        Corners along `up` and across it (m).
    holes
        Corners of each hole (m).

    Raises
    ------
    SceneError
        When the corners enclose no area, or gmsh cannot mesh it.

    Examples
    --------
    >>> from fenics_mech.sections import polygon_numbers
    >>> square = polygon_numbers(((0, 0), (1, 0), (1, 1), (0, 1)))
    >>> round(square.torsion, 5), round(square.area, 9)
    (0.14058, 1.0)
    """
    corners = np.array(outline, dtype=float)
    size = float(np.ptp(corners, axis=0).min())
    edges = corners[:, 0] * np.roll(corners[:, 1], -1) - corners[:, 1] * np.roll(corners[:, 0], -1)
    if not abs(float(np.sum(edges))) / 2 > FLAT * size**2:
        raise SceneError("the corners of the section enclose no area", place="sections")
    loops = [corners / size, *(np.array(hole, dtype=float) / size for hole in holes)]
    _check_loops(loops)
    mesh = _mesh_of(loops[0], loops[1:])
    space = _fenicsx.lagrange(mesh, 2)
    one = _fenicsx.constant(mesh, 1.0)
    place, dx = ufl.SpatialCoordinate(mesh), ufl.dx
    area = _fenicsx.integral(one * dx)
    centre = np.array([_fenicsx.integral(place[i] * dx) for i in range(2)]) / area
    # constants, since numbers in forms would have every polygon compile its own
    y, z = (place[i] - _fenicsx.constant(mesh, float(centre[i])) for i in range(2))

    w, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    stiffness = _fenicsx.assemble_matrix(ufl.inner(ufl.grad(w), ufl.grad(v)) * dx)
    warping = _fenicsx.function_of(space, _free(stiffness, _fenicsx.assemble_vector((z * v.dx(0) - y * v.dx(1)) * dx)))
    strain = warping.dx(0) - z, warping.dx(1) + y
    torsion = _fenicsx.integral((y * strain[1] - z * strain[0]) * dx)
    along, across, both = (_fenicsx.integral(f * dx) for f in (y * y, z * z, y * z))
    mean = _fenicsx.integral(warping * dx) / area
    by_y, by_z = (_fenicsx.integral((warping - _fenicsx.constant(mesh, mean)) * f * dx) for f in (y, z))
    second, first = np.linalg.solve([[both, -along], [across, -both]], [-by_y, -by_z])  # (y_S, z_S)
    shear_centre = np.array([second, first])

    turn = np.arctan2(2 * both, along - across) / 2 if abs(both) > 1e-9 * (along + across) else 0.0
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    mean_inertia, half = (along + across) / 2, np.hypot((along - across) / 2, both)
    inertia = (mean_inertia + half, mean_inertia - half) if turn else (along, across)
    steepest = _fenicsx.largest_at_vertices(mesh, ufl.sqrt(strain[0] ** 2 + strain[1] ** 2))
    sharp = len(holes) > 0 or _has_notch(corners)  # stress in a notch without a radius has no bound
    return PolygonNumbers(
        area=area * size**2,
        inertia=(inertia[0] * size**4, inertia[1] * size**4),
        torsion=torsion * size**4,
        corners=(corners - centre * size) @ axes.T,
        torsion_modulus=None if sharp else torsion / steepest * size**3,
        turn=float(turn),
        shear_centre=tuple(float(x) for x in axes @ shear_centre * size),  # type: ignore[arg-type]
    )


def _check_loops(loops: list[Array]) -> None:
    """Raise `SceneError` where corners make no polygon with holes, at which gmsh may go on for ever."""
    hint = "Name each corner once; sides must not meet, and holes lie inside"
    first, last = (np.concatenate([np.roll(loop, k, axis=0) for loop in loops]) for k in (0, -1))
    after = np.concatenate([np.roll(np.arange(len(x)), -1) + sum(map(len, loops[:k])) for k, x in enumerate(loops)])

    def side(a: Array, b: Array, c: Array) -> Array:
        """Twice the area between places, positive where the third lies on the left of the way between both others."""
        return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])

    a, b = first[:, None], last[:, None]
    of_first, of_last = side(a, b, first[None]), side(a, b, last[None])  # of every side's corners to every side
    apart = np.minimum(of_first, of_last) > 0
    apart |= np.maximum(of_first, of_last) < 0
    low, high = np.minimum(first, last), np.maximum(first, last)
    boxes = ((low[:, None] > high[None]) | (high[:, None] < low[None])).any(axis=-1)
    meet = ~(apart | apart.T | boxes)
    count = np.arange(len(first))
    meet[count, count] = meet[count, after] = meet[after, count] = False
    folded = np.abs(side(first, last, last[after])) <= FLAT  # the next side lies along this one, perhaps back on it
    back = np.sum((last - first) * (last[after] - last), axis=-1) <= 0
    if meet.any() or (folded & back).any():
        raise SceneError("sides of the section meet or cross", place="sections", hint=hint)
    for hole in loops[1:]:
        x, y = hole[0]
        one, other = loops[0], np.roll(loops[0], -1, axis=0)
        over = (one[:, 1] > y) != (other[:, 1] > y)
        way = np.where(over, other[:, 1] - one[:, 1], 1.0)
        cut = one[:, 0] + (y - one[:, 1]) / way * (other[:, 0] - one[:, 0])
        if not np.sum(over & (cut > x)) % 2:  # sides that a ray from the hole crosses
            raise SceneError("a hole of the section lies outside of it", place="sections", hint=hint)


def _mesh_of(outline: Array, holes: list[Array]) -> object:
    """Mesh a polygon with holes by triangles; its lesser extent is 1."""
    with _gmsh.model() as model:
        geo, loops = model.geo, []
        area = abs(
            float(np.sum(outline[:, 0] * np.roll(outline[:, 1], -1) - outline[:, 1] * np.roll(outline[:, 0], -1)))
        )
        longest = max(1 / ACROSS, (area / 2 / MOST) ** 0.5)
        for corners in (outline, *holes):
            points = [geo.addPoint(*corner, 0.0, longest) for corner in corners]
            lines = [geo.addLine(points[k - 1], points[k]) for k in range(len(points))]
            loops.append(geo.addCurveLoop(lines))
        surface = geo.addPlaneSurface(loops)
        geo.synchronize()
        model.addPhysicalGroup(2, [surface], 1)
        try:
            model.mesh.generate(2)
        except Exception as error:  # gmsh raises this alone
            raise SceneError(
                f"gmsh cannot mesh the polygon of the section: {error}",
                place="sections",
                hint="Its sides must not cross, and holes lie inside",
            ) from error
        return _fenicsx.plane_mesh(model)


def _free(matrix: sp.csr_matrix, right: Array) -> Array:
    """Solve a problem whose answer has a free constant: its first value is 0."""
    x = np.zeros(len(right))
    A = to_petsc(sp.csr_matrix(matrix[1:, 1:]))
    solution, given = A.createVecs()
    given.setArray(right[1:])
    with configured(PETSc.KSP().create(PETSc.COMM_SELF), "fenics_mech_torsion_", DIRECT, {}) as ksp:
        ksp.setOperators(A)
        ksp.solve(given, solution)
    x[1:] = solution.getArray()
    for thing in (A, solution, given):
        thing.destroy()
    return x


def _has_notch(corners: Array) -> bool:
    """Say whether a corner points inwards."""
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return bool((turns > 0).any() and (turns < 0).any())
