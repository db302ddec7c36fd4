"""Members that cannot stretch: fewer coordinates, axial forces by equilibrium, and the limit of stiff members."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.response.setup import mechanism
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.files import load
from tests.common import DEMOS, response_of, scene_modes
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


def test_a_four_bar_loses_one_coordinate_per_element():
    quasi_static = {"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True}
    for elements in (1, 3):
        mesh = {"elements": elements}
        free, held = (
            mechanism(seed_four_bar(analysis=quasi_static, mesh=mesh, effects=effects)) for effects in ((), HELD)
        )
        assert free.size - held.size == 3 * elements


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


def test_frequencies_are_the_limit_of_those_of_stiff_members():
    analysis = {"sub_intervals": 12, "modes": 4}
    scenes = [four_bar(analysis=analysis, effects=HELD), *(four_bar(k, analysis=analysis) for k in (1, 10, 100))]
    held, *stiff = (scene_modes(scene, mechanism(scene)).frequency for scene in scenes)
    errors = [np.abs(frequency / held - 1).max() for frequency in stiff]
    assert 1e-4 < errors[0] < 1e-2
    assert np.allclose(np.array(errors[:-1]) / errors[1:], 10, rtol=0.02)
    assert np.all(stiff[0] <= held)  # a constraint raises frequencies (Rayleigh)


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


def test_a_loaded_triangle_carries_axial_forces_as_a_truss_of_slender_members():
    # on a pin and a roller, with welded corners: bending of the members takes a share of (r/L)^2 of the load only where
    # they stretch; where they do not, no corner moves and the corners do not turn
    points = {"A": (0, 0), "B": (0.6, 0), "C": (0.3, 0.4)}
    members = [("A", "B"), ("B", "C"), ("A", "C")]
    scene = frame(points, members, {"A": PIN, "B": ROLLER}, loads={"top": {"at": "frame.C", "force": (0, -80.0)}})
    assert mechanism(scene).size == mechanism(scene.changed(effects=())).size - 9  # three elements in each member
    data = analyse(scene).data.isel(theta=0)
    sides, base = -80 / 2 / 0.8, 80 / 2 / 0.8 * 0.6  # by the method of joints
    for member, expected in (("frame.AB", base), ("frame.BC", sides), ("frame.AC", sides)):
        assert np.allclose(data["axial_force"].sel(member=member), expected, rtol=1e-10)
    assert np.abs(data["moment"]).max() < 1e-10
    assert np.abs(data["deflection"]).max() < 1e-15


def test_a_braced_square_is_refused():
    points = {"A": (0, 0), "B": (0.4, 0), "C": (0.4, 0.4), "D": (0, 0.4)}
    sides = [("A", "B"), ("B", "C"), ("C", "D"), ("D", "A")]
    one, two = [("A", "C")], [("A", "C"), ("B", "D")]
    mechanism(frame(points, sides + one, {"A": PIN, "B": ROLLER}))
    with pytest.raises(SceneError, match="members of link frame brace each other: 1 more"):
        mechanism(frame(points, sides + two, {"A": PIN, "B": ROLLER}))


def test_a_member_held_along_its_axis_at_both_ends_is_refused():
    points = {"A": (0, 0), "B": (0.4, 0)}
    mechanism(frame(points, [("A", "B")], {"A": WELD, "B": ROLLER}))
    with pytest.raises(AssemblyError, match="hold it more than once"):
        mechanism(frame(points, [("A", "B")], {"A": WELD, "B": WELD}))


def test_large_rotations_are_refused():
    with pytest.raises(SceneError, match="exclude each other"):
        analyse(seed_four_bar(effects=("inextensible", "large-rotations")))


def test_geometric_stiffness_takes_the_axial_forces():
    analysis = {"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True}
    effects = ("geometric-stiffness",)
    free, held = (
        mechanism(seed_four_bar(analysis=analysis, effects=more)).terms.stiffening.force
        for more in (effects, effects + HELD)
    )
    assert np.abs(held - free).max() < 1e-11 * np.abs(free).max()


def test_other_effects_of_beams_go_with_it():
    # the limit again, with shear, rotary inertia (which falls with the density here) and lumps
    analysis = {"method": "quasi-static", "sub_intervals": 8, "modes": 3}
    others = ("lumped-mass", "rotary-inertia", "shear")

    def frequency(stiffening, effects):
        data = four_bar(stiffening, analysis=analysis, effects=effects).model_dump(by_alias=True)
        for section in data["sections"].values():
            section["shear_factor"] = 0.5 / stiffening
        for material in data["materials"].values():
            material["shear_modulus"] = 1e7
        scene = Scene.read(data)
        return scene_modes(scene, mechanism(scene)).frequency

    errors = [np.abs(frequency(k, others) / frequency(k, others + HELD) - 1).max() for k in (10, 100)]
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.1)
