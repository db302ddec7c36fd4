"""Collocation: its orders, its points between, a nonlinear motion, resonance."""

import re

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SolverError
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of, too_coarse
from tests.hard_cases.hard import arm, critical


@pytest.mark.parametrize("solver", ["collocation", "harmonic-balance"])
@pytest.mark.parametrize(("harmonic", "mode"), [(1, 1)])
def test_undamped_resonance_is_named(solver, harmonic, mode):
    modes = analyse(arm(1.0, analysis={"sub_intervals": 24, "modes": 3, "solver": "sub-intervals"}))
    frequency = float(modes.data["frequency"][0, mode - 1])
    analysis = {"sub_intervals": 96, "modes": 3, "solver": solver, "harmonics": 10, "allow_large": True}
    scene = arm(critical(arm(1.0), harmonic)[mode - 1], analysis=analysis)
    with pytest.raises(SolverError, match="resonance") as found:
        analyse(scene)
    text = re.search(r"mode (\d+) \((\S+) Hz\), .* harmonic (\d+) of the drive", str(found.value))
    assert text is not None
    assert (int(text[1]), int(text[3])) == (mode, harmonic)
    assert float(text[2]) == pytest.approx(frequency, rel=1e-5)  # six digits are printed
    assert analyse(scene.changed(drive__speed=1.01 * scene.drives[0].speed)).data["deflection"].notnull().all()


@pytest.mark.long
@pytest.mark.slow
def test_error_estimate_of_the_seed_four_bar():
    """Within a factor of 3 of the true one, which spans four powers of ten; too long steps are refused."""
    scene = seed_four_bar(effects=("coupling",), analysis={"solver": "collocation", "stability": False})
    finest = response_of(scene.changed(analysis__sub_intervals=720)).data
    fine = finest["strain"]
    peak = np.abs(fine).max(dim=("theta", "s", "fibre"))
    for stages, count in ((2, 120), (3, 72), (3, 360)):
        steps = {"sub_intervals": count, "stages": stages, "allow_coarse": True}
        data = analyse(scene.changed(analysis=scene.analysis.model_copy(update=steps))).data
        error = np.abs(data["strain"] - fine[:: 720 // count].to_numpy()).max(dim=("theta", "s", "fibre"))
        assert (data["strain_error"].sel(source="time") < 3 * error).all()
        assert (data["strain_error"].sel(source="time") > error / 3).all()
        force = np.hypot(
            *np.moveaxis((data["joint_force"] - finest["joint_force"][:: 720 // count].to_numpy()).to_numpy(), 2, 0)
        )
        assert (data["joint_force_error"].sel(source="time") > force.max(axis=0) / 3).all()
        assert (data["joint_force_error"].sel(source="time") < 4 * force.max(axis=0)).all()
        whole = float((data["strain_error"].sum("source") / peak).max())
        assert data.attrs["error_estimate"] == pytest.approx(whole, rel=0.05)
    told = too_coarse(scene.changed(analysis__sub_intervals=24))
    assert re.match(r"the sub-intervals are too long: .* Take at least \d+ sub_intervals", told)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("method", ["periodic", "transient"])
def test_strain_of_a_viscous_material_between_few_positions_counts_as_error(method):
    """It is filtered out of the stress at the positions: 24 of them are too few, whatever the steps."""
    scene = seed_four_bar(effects=("coupling",), damping={"material": 5e-3}, mesh={"elements": 2})
    fine = response_of(scene.changed(analysis__stability=False, analysis__allow_coarse=True)).data["strain"]
    analysis = {"sub_intervals": 24, "stability": False, "allow_coarse": True, "method": method, "settled": 1e-6}
    found = analyse(scene.changed(analysis=scene.analysis.model_copy(update=analysis))).data
    turn = np.round(np.degrees(found["theta"].to_numpy()[-24:])).astype(int) % 360
    error = np.abs(found["strain"][-24:] - fine[turn].to_numpy()).max(dim=("theta", "s", "fibre"))
    assert float(error.max()) > 0.02 * np.abs(fine).max()  # measured 2 and 3 %
    assert (found["strain_error"].sel(source="time") > error / 4).all()
    stated = scene.changed(analysis=scene.analysis.model_copy(update=analysis | {"allow_coarse": False}))
    assert "sub-intervals are too long" in too_coarse(stated)


@pytest.mark.long
@pytest.mark.slow
def test_error_after_a_blow_is_estimated():
    """Blows excite vibrations faster than the steps follow: the estimate is at least a third of the true error."""
    blow = {"h": {"at": "B", "angle": np.radians(91.3), "impulse": (0, 0.002)}}
    scene = seed_four_bar(effects=("coupling",), impulses=blow, analysis={"stability": False, "allow_coarse": True})
    fine = response_of(scene.changed(analysis__sub_intervals=1440)).data
    coarse = analyse(scene.changed(analysis__sub_intervals=240)).data
    error = np.abs(coarse["strain"] - fine["strain"][::6].to_numpy()).max(dim=("theta", "s", "fibre"))
    assert (coarse["strain_error"].sel(source="time") > error / 3).all()
