"""The program against the dissertation's own programs: `fenics-mech check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.analysis import analyse
from fenics_mech.answers.solved_by_poses import instants_of
from fenics_mech.classical.bodies import Bodies
from fenics_mech.classical.response import SubIntervals
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.scene.factories import seed_four_bar
from tests.validation.reference.gauss_legendre import gauss_legendre_periodic
from tests.validation.reference.mecqbar import compare_appendix_g, mecqbar
from tests.validation.reference.nine_element import NineElementModel
from tests.validation.reference.periodic_motion import periodic_response
from tests.validation.reference.strain import link_strain

POSITIONS = 24
LINKS = ("crank", "coupler", "follower")
MECQBAR_FIBRES = ("+", "+", "-")  # the follower's axis runs from C to B, and MECQBAR takes the fibre on its other side
MESHES = ({"elements": 1}, {"elements": 3}, {"elements": 16}, {"stations": (0, 0.1, 0.45, 1)})


@dataclass(frozen=True)
class Finding:
    """One comparison.

    Parameters
    ----------
    what
        What was compared with what.
    measured
        The number found, as text.
    bound
        What it has to be, as text.
    holds
        Whether it is.
    """

    what: str
    measured: str
    bound: str
    holds: bool


def _difference(what: str, found: Array, expected: Array, bound: float) -> Finding:
    """Compare in the maximum norm, relative to the largest expected number."""
    error = float(np.abs(found - expected).max() / np.abs(expected).max())
    return Finding(what, f"{error:.1e}", f"<= {bound:.0e}", error <= bound)


def appendix_g() -> list[Finding]:
    """MECQBAR against the printed numbers of Appendix G."""
    comparison = compare_appendix_g()
    return [
        Finding(
            "MECQBAR: printed numbers of appendix G that agree within a unit of their last digit",
            f"{comparison.agreeing} of {comparison.compared}",
            "844 of 844",
            comparison.agreeing == comparison.compared == 844,
        )
    ]


def frequencies() -> list[Finding]:
    """All natural frequencies against the hand-coded model's."""
    scene = seed_four_bar(effects=(), analysis={"sub_intervals": POSITIONS, "modes": "all"})
    made, times = machine_of(scene), instants_of(scene)
    made.machine.chart = Bodies(made)
    omega = SubIntervals.of(scene, made, times, times).modes.omega
    ratio = np.sort(omega, axis=1) / (2 * np.pi) / NineElementModel().frequencies(scene.cycle_rate * times)
    return [_difference("27 natural frequencies", ratio, np.ones_like(ratio), 1e-9)]


def periodic_strains() -> list[Finding]:
    """Periodic mid-span strains against the hand-coded model's, with the same scheme."""
    findings = []
    for modes, join, load in ((5, "physical", "linear"), ("all", "projected", "constant"), (5, "modal", "linear")):
        analysis = {
            "sub_intervals": 96,
            "modes": modes,
            "join": join,
            "load": load,
            "allow_ringing": True,
            "allow_coarse": True,
        }
        result = analyse(seed_four_bar(analysis=analysis))
        model = NineElementModel()
        kept = None if modes == "all" else modes
        response = periodic_response(model, 96, modes=kept, damping=0.02, load=load, join=join)  # type: ignore[arg-type]
        expected = link_strain(model, response.theta, response.displacement, response.acceleration).total
        found = np.stack([result.strain_at(link) for link in LINKS], axis=1)
        name = f"periodic mid-span strains: {modes} modes, {join} join, {load} load"
        findings.append(_difference(name, found, expected, 1e-8))
    coupled = {"sub_intervals": 480, "allow_coarse": True, "stability": False}
    result = analyse(seed_four_bar(effects=("coupling",), analysis=coupled))
    motion = gauss_legendre_periodic(NineElementModel(), 480, damping=0.02, coupling=True)
    by_hand = link_strain(NineElementModel(), motion.theta, motion.displacement, motion.acceleration).total
    found = np.stack([result.strain_at(link) for link in LINKS], axis=1)
    name = "periodic mid-span strains with all coupling, whose modes are damped in other coordinates"
    return [*findings, _difference(name, found, by_hand, 2e-3)]


def quasi_static_strains() -> list[Finding]:
    """Quasi-static mid-span strains against MECQBAR, on several meshes."""
    findings = []
    for mesh in MESHES:
        result = analyse(seed_four_bar(mesh=mesh, analysis={"method": "quasi-static", "sub_intervals": POSITIONS}))
        expected = mecqbar(result.data["theta"].to_numpy())
        found = np.stack([result.strain_at(*place) for place in zip(LINKS, (0.5,) * 3, MECQBAR_FIBRES)])
        printed = np.stack([expected[f"eps{i}"] for i in (1, 2, 3)])
        label = f"{mesh['elements']} elements a link" if "elements" in mesh else "elements of unequal length"
        findings.append(_difference(f"quasi-static mid-span strains against MECQBAR: {label}", found, printed, 1e-9))
    return findings


CHECKS: dict[str, Callable[[], list[Finding]]] = {
    "appendix G": appendix_g,
    "frequencies": frequencies,
    "quasi-static strains": quasi_static_strains,
    "periodic strains": periodic_strains,
}
