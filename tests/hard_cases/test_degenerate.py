"""Input at the ends of what is legal: next to no speed, mass or stiffness, one element, and meshes graded too far.

Right: the answer of the limit, or an error that names the part of the scene.
"""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.scene.factories import seed_four_bar

STIFF = {  # axially, 1e8 times; in bending as before
    f"sections__{name}": {"area": area, "inertia": inertia / 1e8, "fibre": 8e-4}
    for name, area, inertia in (
        ("crank", 1.07e-4, 1.62e-10),
        ("coupler", 4.06e-5, 8.67e-12),
        ("follower", 4.06e-5, 8.67e-12),
    )
}
BY_MATERIAL = {"damping": {"material": 1e-4}}


def seed(analysis, **rest):
    return seed_four_bar(analysis={"sub_intervals": 96, "stations": 5, "modes": 3} | analysis, **rest)


@pytest.mark.parametrize("value", [0.0, float("nan"), float("inf"), 1e150, "-inf rad/s"])
def test_a_speed_that_is_none(value):
    with pytest.raises(SceneError, match=r"^drive"):
        seed({}, drive__speed=value)


@pytest.mark.parametrize("part", ["modulus", "density"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), 1e300])
def test_a_material_that_is_none(part, value):
    with pytest.raises(SceneError, match=rf"materials\.material\.{part}"):
        seed_four_bar().changed(**{f"materials__material__{part}": value})


@pytest.mark.parametrize("speed", [1e-6, 1e-3])
@pytest.mark.parametrize("solver", ["sub-intervals", "collocation"])
def test_next_to_no_speed_is_quasi_static(speed, solver):
    """Strains below 1e-14 are rounding of poses; the vibration is of the order (speed/omega)^2."""
    still = analyse(seed({"method": "quasi-static"}, drive__speed=speed)).data["strain"]
    slow = analyse(seed({"solver": solver}, drive__speed=speed)).data["strain"]
    rounding = 0.0 if solver == "sub-intervals" else 1e-14
    assert np.abs(slow - still).max() < 1e-6 * np.abs(still).max() + rounding
    assert float(still.max()) == pytest.approx(4.678e-7 * speed**2, rel=1e-3)


@pytest.mark.parametrize(
    ("analysis", "rest"),
    [
        ({"method": "quasi-static"}, {}),
        ({"solver": "collocation"}, BY_MATERIAL),
        ({"solver": "collocation"}, {"damping": {"ratio": 0.02}}),
        ({"method": "transient", "cycles": 1, "settled": 0.0, "time_tolerance": 1e-8}, BY_MATERIAL),
    ],
)
def test_links_of_nearly_no_mass_with_masses_at_their_ends(analysis, rest):
    """Axial modes of the links alone go to infinity; what is left goes to a limit linearly in the density."""

    def of(density):
        return analyse(seed(analysis, **rest).changed(materials__material__density=density)).data

    limit, near = of(1e-14), of(1e-6)
    for name in ("strain", "joint_force"):
        # in time viscous stress is balanced by accelerations of links of hardly any mass: 2e-6 of strains
        share = 1e-5 if (name, analysis.get("method")) == ("strain", "transient") else 1e-7
        assert np.abs(near[name] - limit[name]).max() < share * np.abs(limit[name]).max()


def test_a_crank_of_no_mass_carries_its_pin():
    scene = seed({"method": "quasi-static"}).changed(materials__material__density=1e-14, masses__B__mass=0.0)
    pull = analyse(scene).data["axial_force"].sel(member="crank").to_numpy()
    assert pull == pytest.approx(np.full_like(pull, 0.0452 * 4.25 * 0.0254 * 32.3**2), rel=1e-10)


@pytest.mark.parametrize("stations", [(0, 0.5, 1), (0, 1e-3, 0.5, 1), (0, 0.2, 0.9989, 1)])
def test_quasi_static_strains_are_the_same_on_any_legal_mesh(stations):
    """One element is exact; rounding goes with the cube of the shortest, over the member: measured 1e-5 at 1e-3."""
    one = analyse(seed({"method": "quasi-static"}, mesh={"elements": 1})).data["strain"]
    graded = analyse(seed({"method": "quasi-static"}, mesh={"stations": stations})).data["strain"]
    assert np.abs(graded - one).max() < 5e-5 * np.abs(one).max()


@pytest.mark.parametrize(
    "mesh", [{"stations": (0, 1e-6, 0.5, 1)}, {"stations": (0, 0.5, 0.5 + 1e-6, 1)}, {"elements": 8, "grading": 7.2}]
)
def test_meshes_graded_by_a_million_are_refused(mesh):
    """Their strains were 100 % off."""
    with pytest.raises(SceneError, match=r"mesh.*longest element .* times as long as the shortest"):
        seed({}, mesh=mesh)


@pytest.mark.parametrize("damping", [{"material": 1e-4}, {"ratio": 0.02}])
def test_the_motion_of_what_has_no_mass_is_right(damping):
    """Its multipliers were said to be at a resonance, at 108 to 154 Hz."""
    scene = seed({"solver": "collocation"}, damping=damping).changed(materials__material__density=1e-27)
    motion = analyse(scene).data
    limit = analyse(scene.changed(materials__material__density=1e-14)).data
    for name in ("strain", "joint_force"):
        assert np.abs(motion[name] - limit[name]).max() < 1e-8 * np.abs(limit[name]).max()


@pytest.mark.long
def test_modal_damping_of_axially_stiff_links_takes_its_share_of_the_strain_only():
    """Links 1e8 times as stiff axially: their axial modes turn with them, and that damped 270 % of the strain."""
    data = analyse(
        seed({"solver": "collocation", "allow_coarse": True}).changed(materials__material__modulus=71e17, **STIFF)
    ).data
    viscous = np.abs(data["stress"] / 71e17 - data["strain"]).max() / np.abs(data["strain"]).max()
    assert 0.02 < viscous < 0.08  # twice the ratio, of what vibrates
    coarse = analyse(seed({"solver": "collocation", "allow_coarse": True}, mesh={"elements": 2}, **BY_MATERIAL)).data[
        "strain"
    ]
    short = analyse(
        seed({"solver": "collocation", "allow_coarse": True}, mesh={"stations": (0, 1e-3, 0.5, 1)}, **BY_MATERIAL)
    ).data["strain"]
    assert np.abs(short - coarse).max() < 0.02 * np.abs(coarse).max()  # 1 %: its mass moves the modes a little
