"""Inertia of sections whose axes turn far: closed forms, Lagrange's equations, the balance of energy."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.scene.factories import seed_four_bar
from tests.studies.design.test_optimise import derivatives

LENGTH, TURNING, RETARDATION = 10.0, 10.0, 0.3  # of the bar (m), rho I (kg m), and of its material (s)


def thick(effects=(), **more):
    """The seed, with the inertia of its sections; with `shear` its materials say what that needs."""
    known = {f"materials.{name}.poisson": 0.3 for name in seed_four_bar().materials}
    known |= {f"sections.{name}.shear_factor": 0.85 for name in seed_four_bar().sections}
    effects = ("coupling", "large-rotations", "rotary-inertia", *effects)
    return seed_four_bar(effects=effects, analysis__sub_intervals=4).changed(known).changed(**more)


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
