"""The program against the dissertation's own programs: `fenics-mech check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.setup import mechanism

from fenics_mech._arrays import Array
from fenics_mech.analysis import analyse
from fenics_mech.classical.bodies import Bodies
from fenics_mech.classical.response import SubIntervals
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.mechanism import System
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.solved_by_poses import instants_of
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


def matrices() -> list[Finding]:
    """System matrices against those of the hand-coded nine-element model, over 24 positions.

    In the stiffness the coupling stands beside a K 1e7 times as large: rounding takes 8 of its digits.
    """
    system = mechanism(seed_four_bar(analysis={"sub_intervals": POSITIONS}))
    model = NineElementModel()
    order = _reference_order(system, model)
    theta = system.motion.theta
    mass, stiffness = model.mass_stiffness(theta)
    found = [(m[:, :][np.ix_(order, order)], k[:, :][np.ix_(order, order)]) for _, m, k in system.positions()]
    by_hand = model.coupling(theta)
    damping, by_position = (matrix[:, order][:, :, order] for matrix in coupling(system))
    return [
        _difference("mass matrix M (4.57) against nine elements by hand", np.array([m for m, _ in found]), mass, 1e-12),
        _difference("stiffness matrix K (4.58)", np.array([k for _, k in found]), stiffness, 1e-12),
        _difference("coupling in the damping of (4.66), 2 (Md + Mv)", damping, by_hand.damping, 1e-12),
        _difference("coupling in the stiffness of (4.66), Mdd + 2 Mdv + Ma", by_position, by_hand.stiffness, 1e-7),
        _difference("inertia load of (5.1)", system.load[:, order], model.load(theta), 1e-12),
    ]


def coupling(system: System) -> tuple[Array, Array]:
    """What the coupling of rigid and elastic motion adds to the equation that is solved: to damping and to stiffness.

    Both are ``(angles, coordinates, coordinates)``.

    Parameters
    ----------
    system
        The mechanism at the angles.
    """
    terms = (replace(system.terms, coupled=on) for on in (False, True))
    plain, coupled = (Equation(replace(system, terms=each)).linear for each in terms)
    return coupled.damping.full - plain.damping.full, coupled.stiffness.full - plain.stiffness.full


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
    return findings


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


def _reference_order(system: System, model: NineElementModel) -> list[int]:
    """Our coordinate for each dof of the hand-coded model, which has the same elements."""
    mesh = system.beams.mesh
    component = {"u": "x", "w": "y", "phi": "rotation"}
    names = {name: i for i, name in enumerate(system.transformation.names)}
    order = []
    for label in model.dof_labels:
        if len(label) == 2:
            order.append(names[".".join(label)])
            continue
        link, s, kind = label
        length = mesh.member_length[LINKS.index(link)]
        node = int(np.argmin(np.abs(mesh.node_xy[:, 0] - s * length) + 1e3 * (mesh.node_link != LINKS.index(link))))
        order.append(names[f"{mesh.node_name[node]}.{component[kind]}"])
    return order


CHECKS: dict[str, Callable[[], list[Finding]]] = {
    "appendix G": appendix_g,
    "matrices": matrices,
    "frequencies": frequencies,
    "quasi-static strains": quasi_static_strains,
    "periodic strains": periodic_strains,
}
