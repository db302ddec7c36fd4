"""Members that cannot stretch: fewer coordinates, axial forces by equilibrium, and the limit of stiff members."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.files import load
from tests.common import DEMOS, response_of
from tests.validation.reference.mecqbar import mecqbar

HELD = ("inextensible",)


def four_bar(stiffening=1.0, **rest):
    """Make the seed four-bar with EA times a factor: areas grow, densities fall, and EI is given by itself."""
    data = seed_four_bar(**rest).model_dump(by_alias=True)
    for material in data["materials"].values():
        material["density"] /= stiffening
    for section in data["sections"].values():
        section["area"] *= stiffening
    return Scene.read(data)


def frame(points, members, joints, **rest):
    """Make a link of strips between points that nothing drives; it is held to ground points of the same names."""
    return Scene.read(
        {
            "materials": {"steel": {"modulus": 210e9, "density": 7850}},
            "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.004}},
            "ground": {"points": points},
            "links": {
                "frame": {
                    "points": points,
                    "members": {a + b: {"ends": (a, b), "section": "strip", "material": "steel"} for a, b in members},
                }
            },
            "joints": {at: kind | {"connect": (f"ground.{at}", f"frame.{at}")} for at, kind in joints.items()},
            "analysis": {"method": "static", "stations": 5},
            "effects": HELD,
        }
        | rest
    )


WELD, PIN, ROLLER = {"kind": "weld"}, {"kind": "revolute"}, {"kind": "slot"}


def test_axial_and_joint_forces_are_those_of_rigid_body_statics():
    # the linkage is statically determinate: MECQBAR's joint forces, and with them N at the coupler's ends
    found = analyse(seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24}, effects=HELD)).data
    printed = mecqbar(found["theta"].to_numpy())
    at_a = np.stack([printed["XA_N"], printed["YA_N"]], axis=1)
    assert np.allclose(found["joint_force"].sel(joint="A"), at_a, rtol=0, atol=1e-9)
    angle = printed["theta2_rad"]
    axial = -(np.cos(angle) * at_a[:, 0] + np.sin(angle) * at_a[:, 1])
    assert np.allclose(found["axial_force"].sel(member="coupler", s=0), axial, rtol=0, atol=1e-9)


def test_forces_without_coupling_are_those_of_members_that_stretch_and_deflections_their_limit():
    analysis = {"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True}
    held = analyse(four_bar(analysis=analysis, effects=HELD)).data
    stiff = [analyse(four_bar(k, analysis=analysis)).data for k in (1, 10, 100)]
    for name in ("axial_force", "shear_force", "moment", "joint_force", "input_torque"):
        assert np.abs(stiff[0][name] - held[name]).max() < 1e-11 * np.abs(held[name]).max(), name
    errors = [float(np.abs(data["deflection"] - held["deflection"]).max()) for data in stiff]
    assert errors[0] < 0.01 * float(np.abs(held["deflection"]).max())
    assert np.allclose(np.array(errors[:-1]) / errors[1:], 10, rtol=1e-3)  # as 1/EA


def test_the_whole_equation_has_the_limit_of_stiff_members():
    # here the axial forces of stiff members are the less accurate ones: they ring too fast for the steps
    analysis = {"sub_intervals": 192, "solver": "collocation", "stability": False}
    given = {"analysis": analysis, "damping": {"material": 2e-4}}
    held = response_of(four_bar(effects=("coupling", *HELD), **given)).data
    moment, axial = [], []
    for k in (1, 10, 100):
        data = response_of(four_bar(k, effects=("coupling",), **given)).data
        moment.append(float(np.abs(data["moment"] - held["moment"]).max() / np.abs(held["moment"]).max()))
        axial.append(float(np.abs(data["axial_force"] - held["axial_force"]).max() / np.abs(held["axial_force"]).max()))
    assert moment[0] < 5e-3
    assert moment[0] / moment[1] > 7
    assert moment[2] < 5e-4  # moments within elements are read in two ways, which differ by h^2
    assert axial[-1] < 4e-3


@pytest.mark.parametrize("name", ["slider_crank", "quick_return", "manipulator", "counterweighted_rocker", "jansen"])
def test_machines_keep_their_joint_forces(name):
    # of these, the links of Jansen's legs are triangles: their members bend less where they cannot stretch
    scene = load(DEMOS / f"{name}.toml").changed(
        analysis__method="quasi-static", analysis__sub_intervals=12, analysis__allow_coarse=True, effects=()
    )
    free, held = (analyse(scene.changed(effects=effects)).data for effects in ((), HELD))
    assert held.attrs["dofs"] < free.attrs["dofs"]
    for variable, tolerance in (("joint_force", 1e-9), ("input_torque", 1e-9), ("axial_force", 2e-4)):
        change = np.abs(held[variable] - free[variable]).max()
        assert change < tolerance * np.abs(free[variable]).max(), variable


def test_a_slanting_cantilever_carries_its_load():
    # 3-4-5: the load is 10 N along the axis and 5 N across it
    (c, s), length = (0.8, 0.6), 0.5
    points = {"A": (0.1, -0.2), "B": (0.1 + c * length, -0.2 + s * length)}
    force = (10 * c - 5 * s, 10 * s + 5 * c)
    scene = frame(points, [("A", "B")], {"A": WELD}, loads={"tip": {"at": "frame.B", "force": force}})
    data = analyse(scene).data.isel(theta=0, member=0)
    assert np.allclose(data["axial_force"], 10, rtol=1e-12)
    assert np.allclose(data["moment"], 5 * length * (1 - data["s"]), rtol=0, atol=5e-12)
    tip = 5 * length**3 / (3 * 210e9 * 0.02 * 0.004**3 / 12)
    assert np.allclose(data["deflection"].isel(s=-1), [-tip * s, tip * c], rtol=1e-9)


def test_large_rotations_are_refused():
    with pytest.raises(SceneError, match="exclude each other"):
        analyse(seed_four_bar(effects=("inextensible", "large-rotations")))
