"""Mid-span strains of a four-bar from Exudyn: `python -m fenics_mech.studies.peers.exudyn_four_bar FILE`.

Exudyn's geometrically exact beams share with this program's beams, link frames and periodic solver only the rigid-body
position at which they start. The steady state is what is left of that start after some cycles of time integration.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.studies.peers.exudyn_model import (
    FAR,
    NEAR,
    add_mechanism,
    add_sensors,
    check_scene,
    import_exudyn,
    integrate,
)

SEED_RETARDATION = 1.339e-4  # s: a damping ratio of 0.02 at 298.8 rad/s, the seed's coupler on two pins


@dataclass(frozen=True)
class MidSpan:
    """State of the middles of the members over the last cycle.

    Parameters
    ----------
    theta
        Drive angles from 0 (rad), shape ``(angles,)``.
    members
        Labels of the members.
    axial
        Axial strain, shape ``(angles, members)``.
    bending
        Bending strain of the "+" and "-" fibres, shape ``(angles, members, 2)``.
    deflection
        Distance of the middle from the chord between the ends, along its normal (m), shape ``(angles, members)``.
    periodicity
        Largest difference of a fibre strain from that a cycle before, over the member's largest strain.
    seconds
        Time that the integration took (s).
    """

    theta: Array
    members: tuple[str, ...]
    axial: Array
    bending: Array
    deflection: Array
    periodicity: float
    seconds: float

    @property
    def strain(self) -> Array:
        """Strain of the "+" and "-" fibres, shape ``(angles, members, 2)``."""
        return self.axial[..., None] + self.bending

    def refined(self, finer: MidSpan) -> MidSpan:
        """Extrapolate from these and from curves with half the time step, whose error is a quarter (Richardson)."""
        axial, bending, deflection = (
            (4 * getattr(finer, name) - getattr(self, name)) / 3 for name in ("axial", "bending", "deflection")
        )
        return replace(finer, axial=axial, bending=bending, deflection=deflection)

    def difference(self, other: MidSpan) -> Array:
        """Largest difference of the fibre strains from another's, over the other's largest strain, ``(members,)``."""
        return np.abs(self.strain - other.strain).max(axis=(0, 2)) / np.abs(other.strain).max(axis=(0, 2))


def strain_curves(
    scene: Scene, retardation: float, *, elements: int = 16, steps: int = 2880, cycles: int = 16, angles: int = 360
) -> MidSpan:
    """Integrate a four-bar until it is periodic, and give the strains at the middles of its members.

    Parameters
    ----------
    scene
        Links that are one uniform beam each, pinned at their ends, one of them turned at a constant speed by a drive
        on the ground. That beam is clamped to the drive. The scene's own damping is not used.
    retardation
        Ratio of viscous to elastic moduli of the Kelvin-Voigt material (s).
    elements
        Elements per member, an even number.
    steps
        Time steps per cycle, a multiple of `angles`.
    cycles
        Cycles to integrate; the last is returned.
    angles
        Number of drive angles in the result, equally spaced from 0.

    Raises
    ------
    SceneError
        When the scene is not such a linkage.
    MechanismError
        When Exudyn is not installed.
    SolverError
        When the integration fails.
    """
    exu = import_exudyn()
    check_scene(scene)
    if elements < 2 or elements % 2 or steps % angles or cycles < 2:
        raise ValueError(
            f"{elements} elements must be even, {steps} steps a multiple of {angles}, {cycles} cycles >= 2"
        )
    container = exu.SystemContainer()
    system = container.AddSystem()
    beams = add_mechanism(exu, system, scene, retardation, elements)
    sensors = [add_sensors(exu, system, cables, nodes) for cables, nodes in beams.values()]
    system.Assemble()
    start = time.perf_counter()
    integrate(exu, system, scene.period, steps, cycles, angles)
    seconds = time.perf_counter() - start
    states = [_mid_span(system, numbers, angles, scene.period) for numbers in sensors]
    return _last_cycle(scene, tuple(beams), states, angles, seconds)


def _last_cycle(
    scene: Scene, members: tuple[str, ...], states: list[list[Array]], angles: int, seconds: float
) -> MidSpan:
    """Strains in the last of two cycles, and their change since the first."""
    axial, curvature, deflection = (np.stack(parts, axis=-1) for parts in zip(*states))
    fibre = np.stack([scene.rigidity(label, np.array([0.5])).fibre[0] for label in members])
    bending = -curvature[..., None] * fibre
    before, last = (
        MidSpan(scene.drive_angles(angles), members, axial[part], bending[part], deflection[part], math.nan, seconds)
        for part in (slice(angles), slice(angles, None))
    )
    return replace(last, periodicity=float(before.difference(last).max()))


def _mid_span(system: Any, sensors: dict[str, list[int]], angles: int, period: float) -> list[Array]:
    """Axial strain, curvature and distance from the chord over the last two cycles, each ``(2 angles,)``.

    In an element that bends, the axial strain ``u' + w'^2 / 2 + ...`` is right in the mean only: take the mean of the
    two middle elements. The curvature is best at the Gauss points (Barlow 1976): take the even polynomial through the
    four of them that are nearest.
    """
    rows = slice(-2 * angles - 1, -1)
    stored = {
        name: np.stack([system.GetSensorStoredData(i)[rows] for i in numbers]) for name, numbers in sensors.items()
    }
    late = stored["places"][0, :, 0] / period * angles
    if np.abs(late - np.round(late)).max() > 1e-6 or round(late[0]) % angles:
        raise SolverError("Exudyn did not store its results at the drive angles asked for")
    axial, curvature = (stored[name][:, :, 1] for name in ("axial", "curvature"))
    inner, outer = (curvature[1] + curvature[2]) / 2, (curvature[0] + curvature[3]) / 2
    first, middle, last = stored["places"][:, :, 1:3]
    chord, rise = last - first, middle - (first + last) / 2
    away = (chord[:, 0] * rise[:, 1] - chord[:, 1] * rise[:, 0]) / np.linalg.norm(chord, axis=1)
    return [axial.mean(axis=0), (FAR**2 * inner - NEAR**2 * outer) / (FAR**2 - NEAR**2), away]


def converged_seed(elements: int = 32, steps: int = 5760) -> tuple[MidSpan, list[str]]:
    """Curves of the seed four-bar, extrapolated to a vanishing time step, and what their accuracy was measured to be.

    Returns
    -------
    tuple
        The curves, and lines that say how they were made and how far coarser ones are from them.
    """
    scene = seed_four_bar()
    runs = [strain_curves(scene, SEED_RETARDATION, elements=elements, steps=steps // n) for n in (4, 2, 1)]
    before, found = (coarse.refined(fine) for coarse, fine in pairwise(runs))
    rough = strain_curves(scene, SEED_RETARDATION, elements=elements // 2, steps=steps // 2)
    lines = [
        "Seed four-bar, 32.3 rad/s, as geometrically exact beams: strains of the outer fibres at mid-span,",
        "axial strains, and distances of the mid-spans from their chords along the normal (m).",
        f"Exudyn {import_exudyn().__version__}, {elements} ANCFCable2D elements a link, Kelvin-Voigt damping "
        f"{SEED_RETARDATION:g} s, 16 cycles from the rigid motion,",
        f"generalized-alpha with {steps // 2} and {steps} steps per cycle, extrapolated to step 0.",
        "Largest differences in coupler and follower, over the largest strain of each:",
    ]
    compared = {
        f"{steps // 2} steps from {steps}": runs[1].difference(runs[2]),
        f"{steps} steps from step 0": runs[2].difference(found),
        f"step 0 from {steps // 4} and {steps // 2} steps": before.difference(found),
        f"{elements // 2} elements from {elements}, {steps // 2} steps": rough.difference(runs[1]),
    }
    places = [found.members.index(name) for name in ("coupler", "follower")]
    lines += [f"  {what}: " + ", ".join(f"{value:.1e}" for value in by[places]) for what, by in compared.items()]
    return found, [*lines, f"  a cycle from the one before: {found.periodicity:.1e} at most"]


def write_curves(path: Path, curves: MidSpan, comment: list[str]) -> None:
    """Write curves of coupler and follower as CSV, angles in degrees, below a comment."""
    columns = {"theta_deg": np.degrees(curves.theta)}
    pairs = [(name, curves.members.index(name)) for name in ("coupler", "follower")]
    for name, i in pairs:
        columns |= {f"{name}_plus": curves.strain[:, i, 0], f"{name}_minus": curves.strain[:, i, 1]}
    columns |= {f"{name}_axial": curves.axial[:, i] for name, i in pairs}
    columns |= {f"{name}_deflection": curves.deflection[:, i] for name, i in pairs}
    rows = [",".join(f"{value:.7g}" for value in row) for row in zip(*columns.values())]
    path.write_text("\n".join([*(f"# {line}" for line in comment), ",".join(columns), *rows, ""]))


if __name__ == "__main__":
    write_curves(Path(sys.argv[1]), *converged_seed())
