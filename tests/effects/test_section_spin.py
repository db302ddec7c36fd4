"""Inertia of sections whose axes turn far: closed forms, Lagrange's equations, the balance of energy."""

from dataclasses import replace

import numpy as np
import pytest
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.setup import mechanism
from fenics_mech.response.static.equilibrium import STATIC
from fenics_mech.response.static.quasi_static import solve_static

import fenics_mech as fm
from fenics_mech.response.static import quasi_static
from fenics_mech.scene.factories import seed_four_bar
from tests.effects import strips
from tests.studies.design.test_optimise import derivatives

LENGTH, TURNING, RETARDATION = 10.0, 10.0, 0.3  # of the bar (m), rho I (kg m), and of its material (s)


def thick(effects=(), **more):
    """The seed, with the inertia of its sections; with `shear` its materials say what that needs."""
    known = {f"materials.{name}.poisson": 0.3 for name in seed_four_bar().materials}
    known |= {f"sections.{name}.shear_factor": 0.85 for name in seed_four_bar().sections}
    effects = ("coupling", "large-rotations", "rotary-inertia", *effects)
    return seed_four_bar(effects=effects, analysis__sub_intervals=4).changed(known).changed(**more)


@pytest.mark.slow  # steps of bending links
def test_a_bar_that_turns_far_in_its_frame_has_the_inertia_of_its_true_rate():
    """A bar ``w = x sin(phi)``: the energy is ``rho I L (omega + phi')^2/2``, the moment on phi ``rho I L phi''``."""
    scene = strips.beam({"O": {}}, effects=("coupling", "large-rotations", "rotary-inertia"), mesh={"elements": 3})
    system = mechanism(scene.changed(analysis__method="static"))
    spin, mesh = system.spin, system.beams.mesh
    share = scene.rigidity("beam", np.array([0.5])).rotary_inertia.item() * strips.L
    phi, rate, second, omega, alpha = 0.9, 3.0, -20.0, 5.0, 70.0
    x = mesh.node_xy[:, 0]
    shape = np.column_stack([0 * x, x, np.ones_like(x)]).reshape(1, -1)
    sine = (np.sin(phi), np.cos(phi) * rate, np.cos(phi) * second - np.sin(phi) * rate**2)
    v, v_rate, v_second = (part * shape for part in sine)
    energy = spin.energy(v, v_rate, np.array([[omega]])).sum() + share * (omega + sine[1]) ** 2 / 2
    assert energy == pytest.approx(share * (omega + rate) ** 2 / 2, rel=1e-12)
    needed = share * (alpha + second)
    on_frame = spin.on_frames(v, v_rate, v_second).sum() + share * (alpha + sine[2])
    assert on_frame == pytest.approx(needed, rel=1e-12)
    forces = spin.force(v, v_rate, v_second, np.array([[alpha]]))
    work = np.sum(forces * shape[:, spin.dofs]) + share * (alpha + sine[2])
    assert work * np.cos(phi) == pytest.approx(needed, rel=1e-12)


@pytest.mark.parametrize("effects", [(), ("shear",)])
def test_forces_and_tangents_are_derivatives_of_the_energy(effects):
    """Lagrange's equations ``d/dt dT/dv' - dT/dv``, and their derivatives by v, v' and v''."""
    spin, rng = mechanism(thick(effects)).spin, np.random.default_rng(0)
    links, size = spin.link.max() + 1, spin.dofs.max() + 1
    v, rate, second = (scale * rng.standard_normal((4, size)) for scale in (6e-3, 1.0, 100.0))
    omega, alpha = (scale * rng.standard_normal((4, links)) for scale in (30, 500))
    force, step, moment = spin.force(v, rate, second, alpha), 1e-5, 1e-6

    def later(time):
        return v + rate * time + second * time**2 / 2, rate + second * time, omega + alpha * time

    def by_rate(time, way, turn):
        there, moved, turned = later(time)
        ahead, behind = (spin.energy(there, moved + s * way, turned + s * turn) for s in (moment, -moment))
        return (ahead - behind) / (2 * moment)

    constant, *tangents = spin.linearised(v, rate, second, alpha)
    state = (v, rate, second)
    of_elements = (part[:, spin.dofs] for part in state)
    linear = constant + sum(np.einsum("teij,tej->tei", *each) for each in zip(tangents, of_elements))
    assert np.allclose(linear, force, rtol=0, atol=1e-12 * np.abs(force).max())
    for way in np.eye(size)[::7]:
        lagrange = (by_rate(step, way, 0) - by_rate(-step, way, 0)) / (2 * step)
        ahead, behind = (spin.energy(v + s * way, rate, omega) for s in (moment, -moment))
        lagrange -= (ahead - behind) / (2 * moment)
        assert np.allclose(np.sum(force * way[spin.dofs], axis=-1), lagrange, atol=1e-4 * np.abs(force).max())
        for i, (matrices, by) in enumerate(zip(tangents, (1e-7, 1e-5, 1e-3))):
            moved = [[part + s * by * way * (i == k) for k, part in enumerate(state)] for s in (1, -1)]
            found = np.subtract(*(spin.force(*each, alpha) for each in moved)) / (2 * by)
            wanted = np.einsum("teij,ej->tei", matrices, way[spin.dofs])
            assert np.allclose(found, wanted, rtol=0, atol=1e-7 * np.abs(matrices).max())
    frames = (by_rate(step, 0 * v, 1) - by_rate(-step, 0 * v, 1)) / (2 * step)
    assert np.allclose(spin.on_frames(v, rate, second), frames, rtol=0, atol=1e-4 * np.abs(frames).max())


def test_the_linearised_equation_has_the_residual_of_its_state():
    system, rng = mechanism(thick()), np.random.default_rng(0)
    equation = Equation(system)
    q, rate, second = (scale * rng.standard_normal((4, system.size)) for scale in (1e-3, 0.1, 10.0))
    residual, about = equation.residual(q, rate, second), equation.about(q, rate, second)
    assert np.allclose(about.left(q, rate, second) - about.load, residual, rtol=0, atol=1e-12 * np.abs(residual).max())
    found = equation.residual(q, rate, equation.acceleration(q, rate))
    assert np.abs(found).max() < 1e-12 * np.abs(residual).max()


def test_without_the_inertia_of_sections_there_is_none():
    assert mechanism(seed_four_bar(effects=("coupling", "large-rotations"))).spin is None
    assert mechanism(seed_four_bar(effects=("coupling", "rotary-inertia"))).spin is None


def swung(**analysis):
    """A bar that its end swings by 0.4 rad: plies far from its axis have its mass, and it bends by 0.5 rad."""
    core, ply = 0.6**0.5, 0.01  # thickness with EA = 1e4 and EI = 500, and of a ply with half of the mass
    gap = TURNING**0.5 - core / 2 - ply / 2
    plies = (fm.Ply(thickness=ply, material="lead"), fm.Ply(thickness=gap, material="foam"))
    plies = (*plies, fm.Ply(thickness=core, material="metal"), *plies[::-1])
    stated = {"sub_intervals": 60, "stages": 3, "solver": "collocation", "stations": 9, "allow_coarse": True}
    return fm.Scene(
        name="swung bar",
        materials={
            "metal": fm.Material(modulus=1e4 / core, density=1e-9),
            "foam": fm.Material(modulus=1e-6, density=1e-9),
            "lead": fm.Material(modulus=1e-6, density=1 / (2 * ply)),
        },
        sections={"bar": fm.LaminateSection(width=1.0, plies=plies)},
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "bar": fm.Link(
                points={"A": (0, 0), "B": (LENGTH, 0)},
                members={"AB": fm.Member(ends=("A", "B"), section="bar", material="metal")},
            )
        },
        joints={"O": fm.Revolute(connect=("ground.O", "bar.A"))},
        drive=fm.Drive(joint="O", law=fm.Harmonics(sine=(0.4,)), period=14.0),
        damping=fm.Damping(material=RETARDATION),
        effects=("coupling", "large-rotations", "rotary-inertia"),
        mesh=fm.Mesh(elements=4),
        analysis=fm.Analysis(**{"method": "periodic", "error_estimates": False} | stated | analysis),
    )


@pytest.mark.slow  # a motion in time
def test_a_heavy_bar_that_is_swung():
    """Drive and damping balance; the end of the bar holds what the drive gives; the motion in time comes to the cycle.

    It bends by 0.5248 rad with 32 elements, and by 0.503 rad with the inertia of small rotations.
    """
    data = fm.analyse(swung()).data
    assert data["rotation"].max() == pytest.approx(0.5248, rel=1e-2)
    assert data.attrs["power_balance_error"] < 1e-6
    assert "not_estimated" not in data.attrs
    moment, effort = data["moment"].isel(member=0), data["drive_effort"].isel(drive=0)
    largest = float(abs(effort).max())
    assert abs(abs(moment.isel(s=0)) - abs(effort)).max() < 2e-3 * largest
    assert abs(moment.isel(s=-1)).max() < 2e-3 * largest
    in_time = fm.analyse(swung(method="transient", solver="poses", cycles=12, start="rigid", time_tolerance=1e-6)).data
    assert in_time.attrs["power_balance_error"] < 1e-5
    last = in_time["strain"].to_numpy()[-61:-1]
    # by the mesh, whose elements have viscous stresses: at the driven end, and 8e-4 with twice the elements
    assert np.abs(last - data["strain"].to_numpy()).max() < 2e-3 * np.abs(last).max()
    last = in_time["stress"].to_numpy()[-61:-1]
    assert np.abs(last - data["stress"].to_numpy()).max() < 5e-4 * np.abs(last).max()


@pytest.mark.slow  # runs of a study
def test_derivatives_where_sections_turn_far():
    value, names = 50.0, ["strain.max", "torque.rms", "joint_force[O].max"]
    study = {"variables": {"x": {"numbers": ["materials.lead.density"], "between": [45, 55]}}, "minimise": ["mass"]}
    found, exact, _ = derivatives(swung().changed(study=study), names, value)
    for name, slope in exact.items():
        assert found[name] == pytest.approx(slope, rel=1e-6), name  # 2e-4 to 2e-2 off with the mass of small rotations


def test_refined_quasi_static_answers_have_the_inertia_of_their_sections(monkeypatch):
    """Forces by strains left it out: axes that turn by 0.48 rad had a residual of 5e-6 of the load."""
    monkeypatch.setattr(quasi_static, "STATIC", replace(STATIC, refined=0.0))  # else it takes 40 elements
    given = {f"sections.{name}.inertia": 30 * strips.INERTIA for name in seed_four_bar().sections}
    given |= {"drive.speed": 330.0, "mesh.elements": 6}
    analysis = {"method": "quasi-static", "sub_intervals": 4}
    system = mechanism(seed_four_bar(effects=("large-rotations", "rotary-inertia"), analysis=analysis).changed(given))
    q = solve_static(system).displacement
    equation = Equation(replace(system, terms=replace(system.terms, coupled=False)))
    left = equation.residual(q, np.zeros_like(q), np.zeros_like(q))
    assert np.abs(left).max() < 1e-9 * np.abs(system.load).max()  # rounding
