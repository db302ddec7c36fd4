"""The response in time against closed forms and the periodic solvers."""

import json

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of
from tests.response.synthetic import arm


@pytest.fixture(scope="module")
def shaft():
    """An arm under its weight, of 2 elements, with bending that shortens it."""
    rest = {"mesh": {"elements": 2}, "damping": {"material": 1e-2}, "effects": ("coupling", "large-rotations")}
    analysis = {"sub_intervals": 64, "stability": False, "time_tolerance": 1e-6, "allow_coarse": True}
    return arm(20.0, **rest, analysis=analysis)


def in_time(scene, **analysis):
    return response_of(
        scene.changed(analysis__method="transient", **{f"analysis__{k}": v for k, v in analysis.items()})
    )


@pytest.mark.slow
@pytest.mark.parametrize("run_up", [None, 0.5])
def test_becomes_the_periodic_motion(shaft, run_up):
    """From rest at full speed, and through a run-up, which ends in the same motion at other drive angles."""
    periodic = response_of(shaft.changed(analysis__solver="collocation", analysis__stages=5)).data
    started = in_time(shaft.changed(drive__run_up=run_up), cycles=20, settled=1e-7).data
    assert started.attrs["cycle_change"] < 1e-7
    assert started.sizes["theta"] < 20 * 64
    peak = float(np.abs(periodic["stress"]).max())
    theta = started["theta"].to_numpy()[-64:]
    tip = np.interp(theta % (2 * np.pi), *_closed(periodic, periodic["stress"][:, 0, 0, 0].to_numpy()))
    assert np.abs(started["stress"][-64:, 0, 0, 0].to_numpy() - tip).max() < 5e-3 * peak  # linear between 64 angles
    if run_up is None:
        # what the material damps is taken from strains element by element: 5.5e-3, and 1.6e-3 and 8e-4 with 4 and 8
        for name, tolerance in {"deflection": 2e-3, "stress": 1e-6, "strain": 8e-3}.items():
            last, exact = started[name].to_numpy()[-65:-1], periodic[name].to_numpy()
            assert np.abs(last - exact).max() < tolerance * np.abs(exact).max()


@pytest.mark.slow
def test_four_bar_becomes_periodic():
    """All that turns and bends, with ratios of its modes and one element a member."""
    scene = seed_four_bar(
        mesh={"elements": 1},
        effects=("coupling", "large-rotations"),
        damping__ratio=0.1,
        analysis={"sub_intervals": 240, "stages": 5, "allow_coarse": True},
    )
    exact = response_of(scene.changed(analysis__solver="collocation", analysis__stability=False)).data["strain"]
    found = in_time(scene, cycles=6, settled=1e-7, time_tolerance=1e-7).data["strain"].to_numpy()[-241:-1]
    assert np.abs(found - exact.to_numpy()).max() < 1e-4 * np.abs(exact).max()


def test_cycles_are_counted_after_the_run_up(shaft):
    found = in_time(shaft.changed(effects=(), drive__run_up=1.0), cycles=2, settled=0).data
    assert found["theta"].to_numpy()[-1] - found["theta"].to_numpy()[-129] == pytest.approx(4 * np.pi)
    assert 1.0 <= float(found["time"][-129]) < 1.0 + shaft.period / 64


def _closed(periodic, values):
    return np.append(periodic["theta"], 2 * np.pi), np.append(values, values[0])


@pytest.mark.slow
def test_goes_on_from_a_file(shaft, tmp_path):
    whole = in_time(shaft, cycles=4, settled=0)
    first = in_time(shaft, cycles=2, settled=0)
    rest = in_time(shaft, cycles=2, settled=0, start=str(first.save(tmp_path / "first.nc")))
    assert float(rest.data["time"][0]) == pytest.approx(float(first.data["time"][-1]))
    assert float(rest.data["theta"][-1]) == pytest.approx(8 * np.pi)
    old, new = whole.data["deflection"].to_numpy()[128:], rest.data["deflection"].to_numpy()
    assert np.abs(old - new).max() < 1e-6 * np.abs(old).max()  # the steps are others
    with pytest.raises(SceneError, match="coordinates, and the scene has"):
        in_time(shaft.changed(mesh__elements=1), start=str(tmp_path / "first.nc"))
    with pytest.raises(SceneError, match="at drive angle 720 deg, where the scene's drive is at 1440 deg"):
        in_time(shaft.changed(drive__speed=2 * shaft.drive.speed), start=str(tmp_path / "first.nc"))


def test_bad_starts_are_refused(shaft, tmp_path):
    periodic = analyse(shaft.changed(effects=(), analysis__sub_intervals=8)).save(tmp_path / "periodic.nc")
    (tmp_path / "text.nc").write_text("no NetCDF")
    for name, words in (
        ("nofile.nc", "analysis.start: there is no file"),
        (tmp_path / "text.nc", "analysis.start: .* is not a result of this program"),
        (periodic, "analysis.start: .* holds no state"),
    ):
        with pytest.raises(SceneError, match=words):
            in_time(shaft, start=str(name))


def test_starts_straight_or_bent(shaft):
    still = analyse(shaft.changed(analysis__method="quasi-static")).data["deflection"].to_numpy()[0]
    straight, bent = (
        in_time(shaft, cycles=1, start=start).data["deflection"].to_numpy() for start in ("rigid", "static")
    )
    assert bent[0] == pytest.approx(still, abs=1e-3 * np.abs(still).max())
    nodes = straight[0, 0, ::10]  # between them bends the particular solution of the inertia
    assert np.abs(nodes).max() < 1e-9 * np.abs(still).max()


def test_impulse_in_a_mechanism(shaft):
    """Once settled, as by collocation of the cycle, whose steps must follow what the blow excites."""
    blow = {"at": "arm.A", "impulse": (0.01, 0.0), "angle": "45 deg"}
    blown = shaft.changed(
        mesh__elements=1, impulses={"blow": blow}, analysis__sub_intervals=16, analysis__allow_coarse=True
    )
    fine = blown.changed(analysis__solver="collocation", analysis__stages=5, analysis__sub_intervals=1024)
    exact = response_of(fine).data["deflection"].to_numpy()[::64, :, ::20]
    found = in_time(blown, cycles=10, settled=1e-7).data["deflection"].to_numpy()[-17:-1]
    assert np.abs(found[:, :, ::20] - exact).max() < 1e-6 * np.abs(exact).max()
    assert np.abs(found).max() < 1.1 * np.abs(exact).max()  # the material's viscous stress bends nothing


def test_what_is_not_solved_in_time_is_refused(shaft):
    with pytest.raises(SceneError, match="more than a result holds"):
        in_time(shaft, cycles=10_000)
    with pytest.raises(SceneError, match=r"analysis\.time_tolerance: 0\.1 is more than"):
        in_time(shaft, time_tolerance=0.1)


def test_linear_effects_are_replaced_by_exact_ones_and_told(shaft):
    found = in_time(shaft.changed(effects=("coupling", "geometric-stiffness")), cycles=1)
    assert "large-rotations" in found.scene.named_effects
    assert "geometric-stiffness" not in found.scene.named_effects
    (told,) = json.loads(found.data.attrs["notices"])
    assert "in place of 'geometric-stiffness'" in told
    assert json.loads(in_time(shaft, cycles=1).data.attrs["notices"]) == []
