"""Linear theories and static answers by the equation of poses: against textbooks and the exact answer."""

import json

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.answers.by_poses import planned
from fenics_mech.answers.solved_by_poses import AtRest, LinearCycle, Run, Solved
from fenics_mech.errors import SolverError
from fenics_mech.estimate.quantities import measures
from fenics_mech.scene import Scene
from tests.common import DEMOS

E, EI, A, L = 71e9, 71e9 * 8.67e-12, 4.06e-5, 0.4
STIFFENED = ("coupling", "geometric-stiffness")
EXACT = ("coupling", "large-rotations")
DERIVED = ("_phase", "vibration_", "gauge_", "stress_ratio", "stress_mean", "_error", "error_", "multiplier", "growth")
WITHIN = {"axial_force", "strain_axial", "shear_force", "euler_ratio"}
UNLIKE = {"assurance", "link_angle", "mean_power"}  # of another definition, or small differences


def cantilever(force, effects=(), elements=4):
    return Scene.read(
        {
            "effects": effects,
            "materials": {"aluminium": {"modulus": E, "density": 2714}},
            "sections": {"strip": {"area": A, "inertia": EI / E, "fibre": 8e-4}},
            "mesh": {"elements": elements},
            "ground": {"points": {"O": (0, 0)}},
            "links": {
                "beam": {
                    "points": {"O": (0, 0), "B": (L, 0)},
                    "members": {"OB": {"ends": ("O", "B"), "section": "strip", "material": "aluminium"}},
                }
            },
            "joints": {"O": {"kind": "weld", "connect": ("ground.O", "beam.O")}},
            "loads": {"tip": {"at": "beam.B", "force": force}},
            "analysis": {"method": "static", "solver": "poses", "allow_coarse": True, "allow_large": True},
        }
    )


def slider_crank(steps=24, **changes):
    made = {"analysis.solver": "poses", "analysis.sub_intervals": steps, "analysis.stations": 5}
    made |= {"analysis.stability": False, "analysis.allow_coarse": True}
    return fm.load(DEMOS / "slider_crank.toml").changed(made, **changes)


def tip(scene):
    return fm.analyse(scene).data["deflection"].isel(theta=0, member=0, s=-1).to_numpy()


def test_a_cantilever_bends_by_the_textbook():
    """P L^3/(3 EI) and N L/(EA), which neither axial forces nor the shortening by bending change."""
    x, y = tip(cantilever((3.0, -0.5)))
    assert x == pytest.approx(3.0 * L / (E * A), rel=1e-6)
    assert y == pytest.approx(-0.5 * L**3 / (3 * EI), rel=1e-7)


@pytest.mark.parametrize("axial", [-3.0, 3.0])
def test_an_axial_force_stiffens_a_cantilever_by_the_textbook(axial):
    """Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., article 1.11: 3 (tan u - u)/u^3 of the deflection."""
    u = np.sqrt(complex(-axial * L**2 / EI))
    _, y = tip(cantilever((axial, -0.5), ("geometric-stiffness",), 16))
    share = (3 * (np.tan(u) - u) / u**3).real
    assert y == pytest.approx(-0.5 * L**3 / (3 * EI) * share, rel=1e-5)


def test_a_cantilever_bends_far_by_the_elastica():
    """Bisshopp and Drucker, Q. Appl. Math. 3 (1945) 272: with P L^2/(EI) = 1 it moves by 0.30172 L and 0.05643 L."""
    x, y = tip(cantilever((0.0, -EI / L**2), EXACT, 16))
    assert -y / L == pytest.approx(0.30172, abs=2e-5)
    assert -x / L == pytest.approx(0.05643, abs=2e-5)


@pytest.mark.parametrize("effects", [("geometric-stiffness",), EXACT, "auto"])
def test_a_column_beyond_its_buckling_load_is_refused(effects):
    """Euler: pi^2 EI/(4 L^2)."""
    load = np.pi**2 * EI / (4 * L**2)
    fm.analyse(cantilever((-0.999 * load, 0.0), effects))
    with pytest.raises(SolverError, match="the mechanism buckles at drive angle 0 deg"):
        fm.analyse(cantilever((-1.001 * load, 0.0), effects))


def test_the_next_correction_of_a_static_answer_is_its_error():
    """With P L^2/(EI) = 0.4 a linear deflection is 3 % too large."""
    scene = cantilever((0.0, -0.4 * EI / L**2))
    data = fm.analyse(scene).data.sel(source="theory")
    linear, exact = (tip(scene.changed(effects=effects)) for effects in ((), EXACT))
    true = np.linalg.norm(exact - linear)
    assert data["deflection_error"].item() == pytest.approx(true, rel=0.02)
    assert true > 0.05 * np.linalg.norm(linear)


@pytest.mark.parametrize("kind", [LinearCycle, AtRest])
@pytest.mark.parametrize("effects", [("coupling",), STIFFENED])
def test_the_next_correction_is_the_error_of_a_linear_theory(kind, effects):
    """Of every quantity, against the exact answer by Newton's method."""
    method = "periodic" if kind is LinearCycle else "quasi-static"
    scene = slider_crank(24, effects=effects, analysis__method=method)
    linear = kind.of(scene)
    here, next_one = (
        x.quantities for x in (linear.positions, linear.corrected if kind is LinearCycle else linear.exact)
    )
    strict = (Solved if kind is LinearCycle else AtRest).of(scene.changed(effects=EXACT))
    exact = strict.positions.quantities
    size = measures(scene, here.largest)
    for what in size:
        told, true = (float((x.minus(here).largest[what] / size[what]).max()) for x in (next_one, exact))
        assert told == pytest.approx(true, rel=0.03), what


@pytest.mark.parametrize("method", ["periodic", "quasi-static"])
def test_where_the_program_chooses_strains_are_exact_and_their_share_is_told(method):
    """The share is that of the coordinates; what linear strains leave out of all quantities is as large as it."""
    told = []
    for speed in ("20 rad/s", "120 rad/s"):
        scene = slider_crank(24, effects="auto", drive__speed=speed, analysis__method=method)
        data = fm.analyse(scene).data
        assert "theory" not in data["source"]
        exact = next(x for x in json.loads(data.attrs["effects"]) if x["name"] == "large-rotations")
        assert exact["acts"]
        linear = fm.analyse(scene.changed(effects=("coupling",), analysis__error_estimates=False)).data
        true = float(abs(linear["deflection"] - data["deflection"]).max() / abs(data["deflection"]).max())
        assert 0.3 * true < exact["size"] < 3 * true
        told.append(exact["size"])
    assert told[0] < 0.1 * told[1]


def test_coupling_acts_where_a_list_leaves_it_out_and_the_result_says_so():
    """Sub-intervals do not know material damping."""
    found = fm.analyse(slider_crank(effects=(), damping={"material": 1e-4}))
    assert any("'coupling' act" in told for told in found.notices)
    known = fm.analyse(slider_crank(effects=("coupling",), damping={"material": 1e-4}))
    assert not known.notices
    np.testing.assert_array_equal(found.data["strain"], known.data["strain"])


def test_a_machine_that_nothing_loads_is_not_refused():
    data = fm.analyse(slider_crank(effects=(), analysis__method="static", analysis__allow_coarse=False)).data
    assert np.abs(data["strain"]).max() < 1e-14
    assert data.attrs["error_estimate"] == 0


def test_where_nothing_acts_linear_strains_leave_nothing_out_that_is_told():
    """Newton's method ends with its first step, which changes nothing."""
    data = fm.analyse(cantilever((0.0, 0.0), effects="auto")).data
    assert not data["strain"].any()
    exact = next(x for x in json.loads(data.attrs["effects"]) if x["name"] == "large-rotations")
    assert exact["size"] is None


def test_a_motion_that_begins_from_the_last_one_does_not_tell_what_linear_strains_leave_out():
    """Its first steps are not those from the rigid motion."""
    before, scene = (planned(slider_crank(24, effects="auto", drive__speed=speed)) for speed in (100.0, 101.0))
    run = Run()
    run.go_to(100.0)
    run.keep(Solved.of(before).cycle.path)
    run.go_to(101.0)
    assert Solved.of(scene, run).left_out is None
    assert Solved.of(scene).left_out == pytest.approx(0.165, rel=0.01)
