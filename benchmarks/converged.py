"""Converged strains to measure errors by: fine meshes and steps, extrapolated, and checked by other ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.cost_grid import meshed
from fenics_mech._arrays import Array
from fenics_mech.analysis import analyse
from fenics_mech.effects.known import COUPLING
from fenics_mech.estimate.quantities import MEASURE
from fenics_mech.recovery import Result
from fenics_mech.recovery.signal import harmonics
from fenics_mech.scene import Scene

CONVERGED_STEPS = ((240, 4), (360, 3))  # sub-intervals and Radau points: of the answer, and of its check
QUICK = ((120, 3), (80, 4))

MESH_ORDERS = {True: 4, False: 2}  # of the strains in the length of the elements: with coupling, and without


@dataclass(frozen=True)
class Difference:
    """Largest differences of strain curves, over each member's largest strain.

    Parameters
    ----------
    everywhere
        Of all members, stations and fibres.
    mid_span
        Of all members at mid-span.
    """

    everywhere: float
    mid_span: float


@dataclass(frozen=True)
class Converged:
    """Strains to measure errors by.

    Parameters
    ----------
    strain
        ``(angles, members, stations, fibres)``, stations from 0 to 1 with one at mid-span.
    uncertainty
        Difference from other settings.
    how
        How they were found and checked.
    """

    strain: Array
    uncertainty: Difference
    how: str

    def error(self, strain: Array) -> Difference:
        """Compare strains of another run with these.

        Parameters
        ----------
        strain
            Strains of the other run, ``(angles, members, stations, fibres)``.
        """
        return difference(strain, self.strain)


def strains(result: Result) -> Array:
    """Strains of the outer fibres, ``(angles, members, stations, fibres)``.

    Parameters
    ----------
    result
        A result of any analysis.
    """
    return result.data["strain"].transpose("theta", "member", "s", "fibre").to_numpy()


def difference(strain: Array, other: Array) -> Difference:
    """Compare strains with others, relative to the largest of each member of those.

    Where a member's largest is below a tenth of that of all, that tenth is the measure, as in the program's estimate.
    They are compared at the angles of the coarser curve where all of them are in the finer one. Else the Fourier series
    of the other is evaluated at the angles of the first.

    Parameters
    ----------
    strain, other
        Strains over one cycle, ``(angles, members, stations, fibres)``.
    """
    largest = np.abs(other).max(axis=(0, 2, 3))
    measure = np.maximum(largest, MEASURE.small_member * largest.max())
    one, two = at_common_angles(strain, other)
    relative = np.abs(one - two).max(axis=(0, 3)) / measure[:, None]
    return Difference(float(relative.max()), float(relative[:, relative.shape[1] // 2].max()))


def at_common_angles(curves: Array, others: Array) -> tuple[Array, Array]:
    """Give two sets of curves over one cycle, ``(angles, ...)``, at angles that they share.

    Parameters
    ----------
    curves, others
        Values at equal steps of the cycle from 0 on, ``(angles, ...)`` with any number of angles each.
    """
    count, known = len(curves), len(others)
    if count % known == 0:
        return curves[:: count // known], others
    if known % count == 0:
        return curves, others[:: known // count]
    series = harmonics(others)
    waves = np.exp(2j * np.pi * np.outer(np.arange(count), np.arange(len(series))) / count)
    return curves, np.asarray(np.tensordot(waves, series, axes=1).real, dtype=np.float64)


def extrapolated(fine: Array, coarse: Array, ratio: float, order: int = 2) -> Array:
    """Extrapolate to elements of no length (Richardson), from two meshes with a ratio of their numbers of elements.

    Parameters
    ----------
    fine, coarse
        Values over one cycle on both meshes, ``(angles, ...)``.
    ratio
        Number of elements of the fine mesh over that of the coarse one.
    order
        Power of the elements' length with which the error falls.
    """
    fine, coarse = at_common_angles(fine, coarse)
    return fine + (fine - coarse) / (ratio**order - 1)


def converged(scene: Scene, meshes: tuple[int, int, int], quick: bool = False) -> Converged:
    """Solve for the converged periodic strains of a scene.

    Parameters
    ----------
    scene
        The scene with its effects.
    meshes
        Elements per member of three meshes, the finest first. The answer is extrapolated from the first two; that from
        the last two, with other steps and another order on the last, is its check.
    quick
        With longer steps.

    Raises
    ------
    MechanismError
        When one of the runs fails.
    """
    fine, other = QUICK if quick else CONVERGED_STEPS

    def run(elements: int, steps: tuple[int, int]) -> Array:
        changed = scene.changed(
            analysis__method="periodic", analysis__solver="collocation", analysis__allow_coarse=True,
            analysis__sub_intervals=steps[0], analysis__stages=steps[1],
        )  # fmt: skip
        return strains(analyse(meshed(changed, elements)))

    first, second, third = run(meshes[0], fine), run(meshes[1], fine), run(meshes[2], other)
    order = MESH_ORDERS[COUPLING in scene.named_effects]
    found = extrapolated(first, second, meshes[0] / meshes[1], order)
    check = extrapolated(second, third, meshes[1] / meshes[2], order)
    how = (
        f"collocation with {fine[1]} Radau points in {fine[0]} sub-intervals, extrapolated from {meshes[0]} and "
        f"{meshes[1]} elements per member; checked by {meshes[1]} and {meshes[2]}, the last with {other[1]} points in "
        f"{other[0]} sub-intervals"
    )
    return Converged(found, difference(check, found), how)


def converged_quasi_static(scene: Scene, elements: int) -> Converged:
    """Give the quasi-static strains of a scene, which are exact on any mesh but for rounding and travelling pins.

    Parameters
    ----------
    scene
        The scene.
    elements
        Elements per member.
    """
    fine, other = (
        strains(analyse(meshed(scene.changed(analysis__method="quasi-static", analysis__sub_intervals=240), n)))
        for n in (elements, max(1, elements // 2))
    )
    return Converged(fine, difference(other, fine), f"{elements} elements per member; checked by half as many")
