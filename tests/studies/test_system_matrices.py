"""Matrices on request solve to the result's own frequencies, and shares of modes make up the strain energy."""

import numpy as np
import pytest
from scipy.linalg import eigh
from typer.testing import CliRunner

from fenics_mech import SceneError, SystemMatrices, load, matrices, participation
from fenics_mech.cli import app
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS, response_of

LINEAR = {"sub_intervals": 12, "modes": 4, "allow_coarse": True, "stability": False, "solver": "collocation"}
BY_POSES = {"effects": ["coupling"], "analysis.solver": "poses"}


@pytest.fixture(scope="module")
def scene():
    return seed_four_bar(effects=[], damping={"ratio": 0.02}, analysis=LINEAR)


@pytest.fixture(scope="module")
def found(scene):
    return matrices(scene).data


@pytest.fixture(scope="module")
def undamped(scene):
    """Give those without damping, which adds to K where it goes with the strain's rate in turning axes."""
    return matrices(scene.changed({"analysis.method": "quasi-static", "damping": {}})).data


def test_their_eigenvalues_are_the_frequencies_of_the_result(scene, undamped):
    frequency = response_of(scene).data["frequency"].to_numpy()
    for k in (0, 5):
        mass, stiffness = (undamped[name][k].to_numpy() for name in ("mass", "stiffness"))
        lowest = np.sqrt(eigh(stiffness, mass, eigvals_only=True)[:4]) / (2 * np.pi)
        assert np.sort(frequency[k]) == pytest.approx(lowest, rel=1e-6)


def test_damping_of_the_ratio_is_that_of_each_mode(found, undamped):
    squares, shapes = eigh(undamped["stiffness"][3].to_numpy(), undamped["mass"][3].to_numpy())
    rates = np.einsum("nm,nk,km->m", shapes, found["damping"][3].to_numpy(), shapes) / (2 * np.sqrt(squares))
    slow = squares < 400 * squares[0]  # faster ones follow their loads, from 32 times the slowest
    assert slow.sum() == 8
    assert rates[slow] == pytest.approx(0.02, rel=1e-3)
    assert rates[-1] == pytest.approx(0, abs=1e-9)


def test_the_static_answer_bends_the_members_as_the_quasi_static_run(scene, found):
    still = response_of(scene.changed({"analysis.method": "quasi-static"})).data["deflection"]
    for k in (0, 7):
        q = np.linalg.solve(found["stiffness"][k].to_numpy(), found["load"][k].to_numpy())
        bent = found["displacement"][k].transpose("column", "member", "s", "component")
        ends = still[k].sel(s=[0.0, 1.0]).transpose("member", "s", "component").to_numpy()
        moved = np.tensordot(q, bent.sel(s=[0.0, 1.0]).to_numpy(), axes=1)
        assert moved == pytest.approx(ends, abs=1e-3 * np.abs(still.to_numpy()).max())


def test_coordinates_move_the_axes_of_sections_beside_their_neutral_line(scene):
    """A pin is on the axes of both links. The neutral line of the laminate is 0.4 mm beside the axis."""
    (name,) = scene.materials
    stiff = {"modulus": 10 * scene.materials[name].modulus, "density": 7800}
    plies = [{"thickness": "1 mm", "material": material} for material in (name, "stiff")]
    laminate = {"shape": "laminate", "width": "25 mm", "plies": plies, "axis": "middle"}
    beam = {"ends": ("A", "B"), "section": "laminate"}
    changes = {"materials.stiff": stiff, "sections.laminate": laminate, "links.coupler.members.AB": beam}
    moved = matrices(scene.changed(changes)).data["displacement"].sel(s=1.0)
    of_coupler, of_follower = (moved.sel(member=member).to_numpy() for member in ("coupler", "follower"))
    assert of_coupler == pytest.approx(of_follower, abs=1e-9 * np.abs(of_follower).max())


def test_modes_share_the_strain_energy(scene):
    """All modes have all of it, but for the loads inside elements; under large rotations few have nearly all, too."""
    every = participation(scene.changed(BY_POSES | {"analysis.modes": 27, "analysis.sub_intervals": 60}))
    shares = every["energy_share"].to_numpy()
    assert shares.sum() == pytest.approx(1, abs=0.03)
    both = {"effects": ["coupling", "large-rotations"], "analysis.sub_intervals": 60}
    exact = participation(scene.changed(BY_POSES | both))
    assert 0.8 < float(exact["energy_share"].sum()) < 1.05
    assert exact["modal_coordinate"].attrs["units"] == "m kg^0.5"


def test_what_has_no_such_matrices_is_refused(scene):
    with pytest.raises(SceneError, match="change with it"):
        matrices(scene.changed({"analysis.method": "transient"}))
    with pytest.raises(SceneError, match="take part in a periodic motion"):
        participation(scene.changed({"analysis.method": "quasi-static"}))


def test_they_are_exported(scene, tmp_path):
    response_of(scene.changed(BY_POSES)).save(tmp_path / "result.nc")
    words = ["export", str(tmp_path / "result.nc"), str(tmp_path / "energy_share.csv")]
    assert CliRunner().invoke(app, [*words, "--matrices", str(tmp_path / "m.nc")]).exit_code == 0
    assert SystemMatrices.load(tmp_path / "m.nc").data["mass"].shape == (12, 27, 27)
    assert len((tmp_path / "energy_share.csv").read_text().splitlines()) == 5
    assert CliRunner().invoke(app, [*words[:2], "--matrices", str(tmp_path / "m.mat")]).exit_code == 0
    assert "matrices are written as" in str(
        CliRunner().invoke(app, [*words[:2], "--matrices", str(tmp_path / "m.csv")]).exception
    )


def test_deflections_in_other_axes_and_relative_centres(scene):
    result = response_of(scene)
    bent, turned = result.data["deflection"], result.derived("deflection_in_link")
    size = [
        (one**2).sum(kind).transpose("theta", "member", "s") for one, kind in ((bent, "component"), (turned, "axis"))
    ]
    assert size[1].to_numpy() == pytest.approx(size[0].to_numpy(), rel=1e-9)
    crank = turned.sel(member="crank", s=1.0)
    assert abs(crank.sel(axis="x")).max() < 1e-2 * abs(crank.sel(axis="y")).max()  # it bends, and hardly stretches
    chord = result.derived("deflection_from_chord")
    bow = abs(chord).max(("theta", "s")) / [0.10795, 0.2794, 0.27051]
    assert bow.to_numpy() == pytest.approx(result.data["bow"].to_numpy(), rel=0.02)


@pytest.mark.parametrize("name", ["four_bar", "slider_crank"])
def test_pins_are_relative_centres_and_three_centres_lie_on_a_line(name):
    changes = {"analysis.method": "quasi-static", "analysis.sub_intervals": 8, "effects": ()}
    result = response_of(load(DEMOS / f"{name}.toml").changed(changes))
    data, first, second = result.data, *list(result.scene.links)[:2]
    centre = result.derived("relative_centre").sel(linked=f"{first}, {second}").to_numpy()
    assert centre == pytest.approx(data["point_position"].sel(point=f"{first}.A").to_numpy(), abs=1e-9)
    own = [data["instant_centre"].sel(link=link).to_numpy() for link in (first, second)]
    arms = [one - centre for one in own]
    across = arms[0][:, 0] * arms[1][:, 1] - arms[0][:, 1] * arms[1][:, 0]
    known = np.isfinite(across)
    assert known.any()
    assert np.abs(across / np.prod([np.linalg.norm(arm, axis=1) for arm in arms], axis=0))[known].max() < 1e-7
