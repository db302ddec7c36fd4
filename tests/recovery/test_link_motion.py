"""Motion of links and points: appendix G of the dissertation, closed forms, and derivatives of the paths in time."""

import numpy as np
import pytest

from fenics_mech import SceneError, load
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.sections import RectangleSection
from tests.common import DEMOS, response_of
from tests.effects.test_offsets import EI, PLACES, L, strip
from tests.effects.turned_machine import ACTING
from tests.recovery.test_momentum import arm
from tests.validation.reference.mecqbar import mecqbar

MIDDLE = {"G2": {"at": "coupler@0.5"}}
RIGID = {"method": "quasi-static", "sub_intervals": 24}


@pytest.fixture(scope="module")
def seed():
    return response_of(seed_four_bar(analysis=RIGID, points=MIDDLE)).data


def test_links_and_points_move_as_appendix_g_prints(seed):
    expected = mecqbar(seed["theta"].to_numpy())
    columns = {"theta": "link_angle", "omega": "link_omega", "alpha": "link_alpha"}
    units = {"theta": "rad", "omega": "rad_s", "alpha": "rad_s2"}
    for i, link in ((2, "coupler"), (3, "follower")):
        for name, variable in columns.items():
            column = expected[f"{name}{i}_{units[name]}"]
            found = seed[variable].sel(link=link).to_numpy()
            assert found == pytest.approx(column, abs=1e-10 * np.abs(column).max()), (name, link)
    for point, name in (("crank.A", "A"), ("follower.B", "B"), ("G2", "G2")):
        for axis in "xy":
            found = seed["point_acceleration"].sel(point=point, component=axis).to_numpy()
            column = expected[f"a{name}{axis}_m_s2"]
            assert found == pytest.approx(column, abs=1e-10 * np.abs(column).max()), (point, axis)
    force = seed["joint_force"].sel(joint="A").to_numpy()
    printed = np.stack([expected["XA_N"], expected["YA_N"]], axis=1)
    assert force == pytest.approx(printed, abs=1e-9 * np.abs(printed).max())


def test_transmission_angle_is_that_between_coupler_and_follower(seed):
    expected = mecqbar(seed["theta"].to_numpy())
    between = np.abs(expected["theta3_rad"] - expected["theta2_rad"])
    assert list(seed["pair"].to_numpy()) == ["B (coupler, follower)"]
    found = seed["transmission_angle"][:, 0].to_numpy()
    assert found == pytest.approx(np.minimum(between, np.pi - between))
    assert seed.attrs["mobility"] == 1


def test_instant_centre_of_the_coupler_is_where_crank_and_follower_meet(seed):
    place = seed["point_position"]
    a, b, c = (place.sel(point=name).to_numpy() for name in ("crank.A", "follower.B", "follower.C"))
    along = np.stack([a, -(b - c)], axis=-1)  # O + t A = C + u (B - C)
    t = np.linalg.solve(along, c[..., None])[:, 0]
    centre = seed["instant_centre"]
    assert centre.sel(link="coupler").to_numpy() == pytest.approx(t * a)
    assert centre.sel(link="crank").to_numpy() == pytest.approx(0 * a, abs=1e-12)
    assert centre.sel(link="follower").to_numpy() == pytest.approx(c)


def in_time(place, period, order):
    """Derivative of a periodic path by its Fourier series."""
    rate = 2j * np.pi * np.fft.rfftfreq(len(place), period / len(place))[:, None]
    return np.fft.irfft(rate**order * np.fft.rfft(place, axis=0), n=len(place), axis=0)


ON_LINKS = MIDDLE | {
    "P": {"at": "coupler@0.3", "offset": ("20 mm", "50 mm")},
    "Q": {"at": "follower.B", "offset": (0, 0.02)},
}
RATES = ((1, "velocity", 1e-5), (2, "acceleration", 2e-3))  # by the solver's steps


@pytest.mark.slow
@pytest.mark.parametrize("effects", [("coupling",), ("coupling", "large-rotations")])
def test_rates_of_bent_links_are_derivatives_of_their_paths(effects):
    scene = seed_four_bar(effects=effects, points=ON_LINKS, analysis={"sub_intervals": 360, "stability": False})
    scene = scene.changed(drive__speed=15.0, **({} if len(effects) == 1 else ACTING | {"damping.material": 3e-3}))
    data = response_of(scene).data
    bent, rigid = data["point_position_bent"], data["point_position"]
    assert data["rotation"].max() > (0.4 if len(effects) > 1 else 0)
    for point in ("follower.B", "coupler.A", *ON_LINKS):
        path = bent.sel(point=point).to_numpy()
        assert np.abs(path - rigid.sel(point=point).to_numpy()).max() > 1e-5
        for order, name, error in RATES:
            found = data[f"point_{name}_bent"].sel(point=point).to_numpy()
            expected = in_time(path, scene.period, order)
            assert found == pytest.approx(expected, abs=error * np.abs(expected).max()), (point, name)
    assert bent.sel(point="coupler.B").to_numpy() == pytest.approx(bent.sel(point="follower.B").to_numpy(), abs=1e-12)


@pytest.mark.parametrize(("effects", "near"), [((), 1e-9), (("large-rotations",), 1e-6)])
def test_an_offset_turns_with_the_section_and_not_with_the_axis(effects, near):
    """A laminate that shears, whose neutral line is beside the axis of its member."""
    force, x, offset = 1e-4, 0.25 * L, (0.02, 0.05)
    scene = strip("middle", {"A": {"kind": "weld"}}, loads={"tip": {"at": "beam.B", "force": (0, force)}})
    points = {"on": {"at": "beam@0.25"}, "beside": {"at": "beam@0.25", "offset": offset}}
    data = response_of(scene.changed(effects=("shear", *effects), points=points, analysis__stations=5)).data
    place = (data["point_position_bent"] - data["point_position"])[0]
    turn = force * x * (2 * L - x) / (2 * EI)
    assert place.sel(point="on", component="x").item() == pytest.approx(PLACES["middle"][0] * turn, rel=near)
    across = data["deflection"].sel(s=0.25, component="y").item()
    assert place.sel(point="on", component="y").item() == pytest.approx(across, rel=near)
    swung = (place.sel(point="beside") - place.sel(point="on")).to_numpy()
    assert swung == pytest.approx(turn * np.array([-offset[1], offset[0]]), rel=near)


def test_points_of_a_bent_beam_move_by_its_deflection_and_rotation():
    length, force = 0.5, -2.0
    stiffness = 206e9 * RectangleSection(width=0.02, height=0.005).inertia
    joints = {"O": {"kind": "weld", "connect": ("ground.O", "arm.O")}}
    points = {"tip": {"at": "arm.B", "offset": (0, 0.1)}, "half": {"at": "arm@0.5", "offset": (0.05, 0.0)}}
    loads = {"F": {"at": "arm.B", "force": (0, force)}}
    scene = arm(joints=joints, drive=(), masses={}, loads=loads, points=points, analysis={"method": "static"})
    data = response_of(scene).data
    assert "point_velocity" not in data
    assert "instant_centre" not in data
    moved = (data["point_position_bent"] - data["point_position"])[0]
    w, slope = force * length**3 / (3 * stiffness), force * length**2 / (2 * stiffness)
    assert moved.sel(point="tip").to_numpy() == pytest.approx([-0.1 * slope, w])
    x = length / 2
    w, slope = force * x**2 * (3 * length - x) / (6 * stiffness), force * x * (2 * length - x) / (2 * stiffness)
    assert moved.sel(point="half").to_numpy() == pytest.approx([0.0, w + 0.05 * slope], abs=1e-14)


def test_slider_goes_as_far_as_its_closed_form():
    scene = load(DEMOS / "slider_crank.toml").changed(analysis__method="quasi-static", analysis__sub_intervals=24)
    data = response_of(scene.changed(effects=())).data
    r = np.hypot(*scene.links["crank"].points["A"])
    rod = scene.links["rod"].points
    length = np.hypot(*np.subtract(rod["B"], rod["A"]))
    theta = data["theta"].to_numpy()
    above = scene.ground.points["G"][1]
    expected = r * np.cos(theta) + np.sqrt(length**2 - (r * np.sin(theta) - above) ** 2)
    assert data["slide_place"].sel(slide="B").to_numpy() == pytest.approx(expected)


@pytest.mark.parametrize("at", ["ground.O", "A"])
def test_point_that_no_link_carries_is_refused(at):
    with pytest.raises(SceneError, match=r"points\.P\.at: a traced point is fixed to a link"):
        seed_four_bar(points={"P": {"at": at}})
