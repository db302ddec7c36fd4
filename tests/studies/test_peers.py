"""The geometrically exact peer: it reproduces its stored curves, and agrees with the linear theory where that holds."""

import sys
from pathlib import Path

import numpy as np
import pytest

from fenics_mech.analysis import analyse
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.scene.factories import seed_four_bar, slider_crank
from fenics_mech.studies.peers.exudyn_four_bar import SEED_RETARDATION, MidSpan, strain_curves, write_curves
from fenics_mech.studies.peers.exudyn_model import check_scene

STORED = Path(__file__).parent.parent / "data" / "seed_exact.csv"
MEMBERS = ("coupler", "follower")


def read(path):
    """Columns of a CSV below a comment."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.genfromtxt(lines, delimiter=",", names=True)


@pytest.fixture(scope="module")
def coarse():
    pytest.importorskip("exudyn")
    return strain_curves(seed_four_bar(), SEED_RETARDATION, elements=8, steps=1440, cycles=8)


@pytest.mark.parametrize("member", MEMBERS)
def test_a_coarse_run_gives_the_stored_curves(coarse, member):
    # Its time step alone leaves 3.3e-3 of the coupler's and 0.9e-3 of the follower's peak, and falls as its square;
    # the mesh leaves 0.8e-3 and 1.3e-3. The deflection is smoother.
    stored, i = read(STORED), coarse.members.index(member)
    assert np.degrees(coarse.theta) == pytest.approx(stored["theta_deg"], abs=1e-5)
    expected = np.stack([stored[f"{member}_{fibre}"] for fibre in ("plus", "minus")], axis=-1)
    assert np.abs(coarse.strain[:, i] - expected).max() < 5e-3 * np.abs(expected).max()
    deflection = stored[f"{member}_deflection"]
    assert np.abs(coarse.deflection[:, i] - deflection).max() < 5e-3 * np.abs(deflection).max()
    assert coarse.periodicity < 3e-4  # the slowest mode decays at 6 1/s: by exp(-6 * 8 * 0.1945) = 1e-4 in 8 cycles


def test_a_slow_crank_bends_its_links_as_the_linear_theory_says():
    # At 2 rad/s the axial force is 0.15 % of the Euler load (it grows as the square of the speed, and is 30 N of 80 at
    # 32.3 rad/s), and so is what it changes of the bending. Signs, axes and fibres must then be the program's.
    pytest.importorskip("exudyn")
    scene = seed_four_bar(drive__speed="2 rad/s", analysis__method="quasi-static")
    exact = strain_curves(scene, SEED_RETARDATION, elements=8, steps=1440, cycles=2)
    linear = analyse(scene)
    for i, member in enumerate(exact.members):
        expected = np.stack([linear.strain_at(member, fibre=fibre) for fibre in "+-"], axis=-1)
        assert np.abs(exact.strain[:, i] - expected).max() < 3e-3 * np.abs(expected).max()
        axial = linear.data["strain_axial"].sel(member=member, s=0.5).to_numpy()
        # Ripple of the start from rest: the step of 2 ms cannot follow axial vibration, and damps it.
        assert np.abs(exact.axial[:, i] - axial).max() < 3e-2 * np.abs(axial).max()


def test_curves_are_written_and_read_back(tmp_path):
    theta = np.array([0.0, np.pi])
    axial, bending = np.array([[1.0, 2.0], [3.0, 4.0]]) * 1e-5, np.array([[-1.0, 1.0], [-2.0, 2.0]]) * 1e-4
    curves = MidSpan(theta, MEMBERS, axial, np.stack([bending, bending], axis=1), axial, 0.0, 0.0)
    write_curves(tmp_path / "curves.csv", curves, ["first", "second"])
    found = read(tmp_path / "curves.csv")
    assert found["theta_deg"].tolist() == [0, 180]
    assert found["follower_plus"] == pytest.approx([-8e-5, -16e-5])
    assert found["coupler_minus"] == pytest.approx([11e-5, 23e-5])


def test_extrapolation_removes_an_error_that_falls_as_the_square_of_the_step():
    def with_error(error):
        one = np.full((1, 1), 1 + error)
        return MidSpan(np.zeros(1), ("coupler",), one, np.stack([one, -one], axis=-1), one, 0.0, 0.0)

    found = with_error(4e-3).refined(with_error(1e-3))
    assert found.axial == pytest.approx(1)
    assert found.strain.ravel() == pytest.approx([2, 0])


ROCKING = {"kind": "harmonics", "sine": (0.5,)}
STRIP = {"section": "coupler", "material": "material"}
IN_TWO = {
    "points": {"A": (0, 0), "M": ("5 in", 0), "B": ("11 in", 0)},
    "members": {"AM": {"ends": ("A", "M"), **STRIP}, "MB": {"ends": ("M", "B"), **STRIP}},
    "angle": "70 deg",
}


def loaded(**load):
    return seed_four_bar(loads={"press": {"at": "follower.B", **load}})


@pytest.mark.parametrize(
    ("scene", "place"),
    [
        (lambda: loaded(force=(5, 0)), "loads"),
        (lambda: seed_four_bar(masses__A__inertia=1e-6), "masses.A"),
        (lambda: seed_four_bar(drive={"joint": "O", "law": ROCKING, "period": 1}), "drive"),
        (lambda: seed_four_bar(links__coupler=IN_TWO), "links.coupler"),
        (
            lambda: seed_four_bar(links__coupler={"points": {"A": (0, 0), "B": ("11 in", 0)}, "rigid": {"mass": 0.1}}),
            "links.coupler",
        ),
        (
            lambda: slider_crank(
                crank=0.05, rod=0.2, sections=[{"shape": "rectangle", "width": 0.02, "height": 0.005}] * 2,
                material={"modulus": 2e11, "density": 7850}, speed=40, masses=(0, 0.2),
            ),
            "joints",
        ),
    ],
)  # fmt: skip
def test_what_the_model_cannot_be_built_for_is_refused(scene, place):
    with pytest.raises(SceneError, match="Exudyn") as refusal:
        check_scene(scene())
    assert refusal.value.place.startswith(place)


def test_a_missing_exudyn_is_said_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    with pytest.raises(MechanismError, match="not installed"):
        strain_curves(seed_four_bar(), SEED_RETARDATION)


@pytest.mark.parametrize("bad", [{"elements": 3}, {"elements": 0}, {"steps": 500}, {"cycles": 1}])
def test_a_bad_discretization_is_refused(bad):
    pytest.importorskip("exudyn")
    with pytest.raises(ValueError, match="elements"):
        strain_curves(seed_four_bar(), SEED_RETARDATION, **bad)
