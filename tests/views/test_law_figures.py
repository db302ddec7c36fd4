"""What is drawn and told of joint laws: efforts with their largest between positions, and orbits of loose pins."""

import numpy as np
import pytest

from fenics_mech.errors import ViewError
from fenics_mech.scene import load
from fenics_mech.views.judgements import headline
from fenics_mech.views.motion_figures import law_efforts, law_figure, open_pins, orbit_figure, plot_pin_orbit
from fenics_mech.views.page.report import page
from fenics_mech.views.reading import reading_of
from fenics_mech.views.result_figures import plot_all
from fenics_mech.views.summary import summary
from tests.common import DEMOS, analysed


def test_the_largest_push_of_a_contact_is_told_and_drawn_between_the_positions(tmp_path):
    result = analysed(load(DEMOS / "joint_laws" / "valve_train.toml"))
    reading = reading_of(result)
    push = next(one for one in law_efforts(result, reading.units) if one.law == "cam:G")
    assert (push.joint, push.kind, push.unit) == ("G", "cam", "N")
    assert push.between
    assert push.largest == pytest.approx(float(result.data["largest_law_effort"].sel(law="cam:G")))
    told = f"Between the positions cam:G at joint G exerts up to {push.largest:.0f}"[:-1]
    assert told in headline(reading)[1]
    assert told in page(result)
    assert f"{push.largest:.0f}" in str(summary(result))
    axes = law_figure(result).axes[0]
    curve, largest = axes.lines[0], axes.lines[-1]
    assert np.abs(curve.get_ydata()).max() < largest.get_ydata()[0] == pytest.approx(push.largest)
    names = {path.name for path in plot_all(result, tmp_path)}
    assert "joint_laws.png" in names
    assert "pin_orbits.png" not in names  # a cam leaves no pin loose
    assert "0 N " in str(summary(result))  # of the guide, which was told as 4e-9 N
    with pytest.raises(ViewError, match="no loose pin 'cam'"):
        plot_pin_orbit(result, "cam")


@pytest.mark.long
@pytest.mark.slow
def test_an_orbit_leaves_its_clearance_by_the_indentation():
    result = analysed(load(DEMOS / "joint_laws" / "rattling_slider_crank.toml"))
    assert open_pins(result) == ["rattle"]
    orbit, _, circle = orbit_figure(result).axes[0].lines
    depth = result.data["indentation"].to_numpy()[:, 0]
    np.testing.assert_allclose(np.hypot(*orbit.get_data()), 0.5 + 1e3 * depth, atol=1e-9)
    np.testing.assert_allclose(np.hypot(*circle.get_data()), 0.5)
