"""Laminates whose centre of mass, neutral line and pins are apart: against closed forms and transfer matrices.

Along the normal, from the member's axis on which the pins are, the neutral line is at A and the centre of mass at B.
"""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene, load
from tests.common import modes_of

L, WIDTH, GRAVITY = 0.4, 0.02, 9.81
THICK, MODULUS, DENSITY = np.array([3e-3, 2e-3]), np.array([70e9, 3e9]), np.array([2700.0, 7000.0])
MIDDLES = np.array([1.5e-3, 4e-3])  # of the plies, from the lower face
NEUTRAL, CENTRE = (np.sum(by * THICK * MIDDLES) / np.sum(by * THICK) for by in (MODULUS, DENSITY))
EA, LINE = WIDTH * np.sum(MODULUS * THICK), WIDTH * np.sum(DENSITY * THICK)
EI, TURNING = (WIDTH * np.sum(by * (THICK**3 / 12 + THICK * (MIDDLES - NEUTRAL) ** 2)) for by in (MODULUS, DENSITY))
ARM = CENTRE - NEUTRAL
PLACES = {"neutral": (0.0, ARM), "middle": (NEUTRAL - 2.5e-3, CENTRE - 2.5e-3)}  # A and B
PLIES = [{"thickness": t, "material": name} for t, name in zip(THICK, ("stiff", "heavy"))]
MATERIALS = {
    name: {"modulus": e, "density": rho, "poisson": 0.3} for name, e, rho in zip(("stiff", "heavy"), MODULUS, DENSITY)
}
PIN, WELD, ROLLER = {}, {"kind": "weld"}, {"kind": "slot", "angle": 0.0}
BOTH = pytest.mark.parametrize("axis", PLACES)


def strip(axis, joints, elements=2, **rest):
    """A strip between points A and B of the ground."""
    return Scene.read(
        {
            "materials": MATERIALS,
            "sections": {"strip": {"shape": "laminate", "width": WIDTH, "plies": PLIES, "axis": axis}},
            "ground": {"points": {"A": (0, 0), "B": (L, 0)}},
            "links": {
                "beam": {
                    "points": {"A": (0, 0), "B": (L, 0)},
                    "members": {"AB": {"ends": ("A", "B"), "section": "strip"}},
                }
            },
            "joints": {name: {"connect": (f"ground.{name}", f"beam.{name}")} | kind for name, kind in joints.items()},
            "mesh": {"elements": elements},
            "analysis": {"method": "static"},
        }
        | rest
    )


def spinning(axis, speed, **rest):
    """The strip on the shaft of a drive."""
    return strip(axis, {"A": PIN}, **({"drive": {"joint": "A", "speed": speed}} | rest))


def of_beam(scene):
    """Arrays at the first position: stations (m), N (N), M (N m), strain of both fibres and deflection (m)."""
    data = analyse(scene).data.isel(theta=0).sel(member="beam")
    names = ("axial_force", "moment", "strain", "deflection")
    return data["s"].to_numpy() * L, *(data[name].transpose("s", ...).to_numpy() for name in names)


@BOTH
@pytest.mark.parametrize("elements", [1, 3])
def test_a_spinning_arm_bends_as_its_mass_pulls_beside_its_neutral_line(axis, elements):
    speed, (a, b) = 50.0, PLACES[axis]
    scene = spinning(axis, speed, elements=elements, analysis={"method": "quasi-static", "sub_intervals": 8})
    x, axial, moment, strain, _ = of_beam(scene)
    # mass at (xi, b) beyond x is pulled by LINE speed^2 (xi, b), on arms from the neutral line at (x, a)
    expected = LINE * speed**2 * (b * (L - x) ** 2 - (b - a) * (L**2 - x**2)) / 2
    if not a:
        assert np.allclose(expected, -ARM * LINE * speed**2 * x * (L - x), rtol=1e-12, atol=1e-15)
    assert np.allclose(moment, expected, rtol=0, atol=1e-10 * np.abs(expected).max())  # statics: exact on any mesh
    stretch = LINE * speed**2 * (L**2 - x**2) / 2 / EA
    assert np.allclose(axial, stretch * EA, rtol=0, atol=1e-10 * EA * stretch.max())
    for i, fibre in enumerate((5e-3 - NEUTRAL, -NEUTRAL)):
        assert np.allclose(strain[:, i], stretch - expected * fibre / EI, rtol=0, atol=1e-10 * np.abs(strain).max())


@pytest.mark.parametrize("effects", [[], ["shear", "rotary-inertia"]])
@BOTH
def test_weight_along_a_strip_bends_it(axis, effects):
    analysis = {"method": "static"}
    x, axial, moment, _, deflection = of_beam(
        strip(axis, {"A": WELD}, elements=3, effects=effects, gravity=(GRAVITY, 0.0), analysis=analysis)
    )
    force = LINE * GRAVITY
    assert np.allclose(axial, force * (L - x), rtol=0, atol=1e-12 * force * L)
    assert np.allclose(moment, -ARM * force * (L - x), rtol=0, atol=1e-10 * ARM * force * L)
    across = -ARM * force / EI * (L * x**2 / 2 - x**3 / 6)  # a moment without a shear force bends, and shears nothing
    # by poses, sections between the ends of an element turn linearly, by which the mass beside it pulls: 1/(4 n^2)
    off, largest = np.abs(deflection[:, 1] - across).max(), np.abs(across).max()
    assert off == pytest.approx(largest / 36, rel=1e-6, abs=1e-10 * largest)
    turned = -ARM * force * L**2 / 2 / EI
    along = force * L**2 / 2 / EA + PLACES[axis][0] * turned  # of the axis, at the end
    assert deflection[-1, 0] == pytest.approx(along, abs=0.03 * np.abs(across).max())


@BOTH
def test_a_strip_that_swings_freely_carries_its_own_inertia(axis):
    (a, b), (pull, push) = PLACES[axis], (3.0, 0.4)
    loads = {"tip": {"at": "beam.B", "force": (pull, push)}}
    x, axial, moment, _, _ = of_beam(strip(axis, {"A": PIN}, loads=loads, analysis={"method": "quasi-static"}))
    rate = push * L / (LINE * L * (L**2 / 3 + b**2))  # Newton and Euler, about the pin
    assert np.allclose(axial, pull + LINE * rate * b * (L - x), rtol=1e-11)
    inertia = (L**3 - x**3) / 3 - x * (L**2 - x**2) / 2 + (b - a) * b * (L - x)
    expected = (L - x) * push + a * pull - LINE * rate * inertia
    assert np.allclose(moment, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("effect", ["geometric-stiffness", "large-rotations"])
def test_a_strut_on_pins_beside_its_neutral_line_obeys_the_secant_formula(effect):
    load, a = 0.5 * np.pi**2 * EI / L**2, PLACES["middle"][0]
    ends = {"A": PIN, "B": ROLLER}
    pressed = {"loads": {"press": {"at": "beam.B", "force": (-load, 0.0)}}}
    moment = of_beam(strip("middle", ends, elements=1, **pressed))[2]
    assert np.allclose(moment, -load * a, rtol=1e-11)
    x, _, moment, _, deflection = of_beam(strip("middle", ends, elements=8, effects=[effect], **pressed))
    k = np.sqrt(load / EI)
    shape = np.cos(k * x) + np.tan(k * L / 2) * np.sin(k * x)  # Timoshenko and Gere, Theory of Elastic Stability, 1.13
    close = 1e-4 if effect == "geometric-stiffness" else 2e-4  # h^4: 2e-5 with 8 elements; the formula lacks slope^2
    assert np.allclose(moment, -load * a * shape, rtol=close)
    assert np.allclose(deflection[:, 1], a * (shape - 1), rtol=0, atol=close * abs(a * (shape - 1)).max())


def frequency(ends, place, near, speed=0.0, turning=None, shear=np.inf):
    """Circular frequency next to `near` of a strip that turns at a speed, by its transfer matrix (rad/s).

    The state is u, w of the neutral line, phi, and the forces N, Q, M about it, proportional to ``exp(i omega t)``.
    """
    scale = np.array([1, 1, 1 / L, EI / L**3, EI / L**3, EI / L**2])
    held = {
        "pin": [[1, 0, place, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 0, -place, 0, 1]],
        "weld": [[1, 0, place, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0]],
        "free": np.eye(6)[3:],
    }
    start, end = (np.array(held[kind], dtype=float) * scale for kind in ends)
    free = np.linalg.svd(start)[2][3:].T
    along, across, turn = np.eye(6)[0] - ARM * np.eye(6)[2], np.eye(6)[1], np.eye(6)[2]  # of the centre of mass

    def lack(omega):
        rates = np.zeros((6, 6), dtype=complex)
        rates[0, 3], rates[1, 2], rates[1, 4], rates[2, 5], rates[5, 4] = 1 / EA, 1, 1 / shear, 1 / EI, -1
        rates[3] = LINE * (-(omega**2 + speed**2) * along - 2j * speed * omega * across)
        rates[4] = LINE * (-(omega**2 + speed**2) * across + 2j * speed * omega * along)
        rates[5] -= ARM * rates[3]
        # turning a section, the mass stays as far from the shaft: no centrifugal force by its own arm
        rates[5] += LINE * ARM**2 * speed**2 * turn
        if turning is not None:
            rates[5] -= omega**2 * (turning - LINE * ARM**2) * turn
        return np.linalg.det(end @ expm(rates * scale / scale[:, None] * L) @ free).real

    return brentq(lack, 0.998 * near, 1.002 * near, xtol=1e-12, rtol=1e-12)


@pytest.mark.parametrize("effects", [(), ("shear", "rotary-inertia")])
@pytest.mark.parametrize("ends", [("pin", "pin"), ("weld", "free")])
@BOTH
def test_natural_frequencies_are_those_of_the_transfer_matrix(axis, ends, effects):
    joints = {name: {"pin": PIN, "weld": WELD}[kind] for name, kind in zip("AB", ends) if kind != "free"}
    scene = strip(axis, joints, elements=12, effects=effects, analysis={"method": "static", "modes": 2})
    thick = {"turning": TURNING, "shear": float(scene.shear_stiffness("beam", np.zeros(1))[0])} if effects else {}
    found = modes_of(scene).modes.omega[0]
    expected = [frequency(ends, PLACES[axis][0], omega, **thick) for omega in found]
    # h^4: 6e-5 for two half-waves on 12 elements; by shear h^2, 8.4e-5
    assert found == pytest.approx(expected, rel=9e-5 if effects else 8e-5)


def test_pins_beside_the_neutral_line_stiffen_a_strip_between_fixed_pins():
    first = [frequency(("pin", "pin"), PLACES[axis][0], near) for axis, near in (("neutral", 183.7), ("middle", 236.2))]
    assert first[1] > 1.28 * first[0]  # what the scene says of its axis is no detail


def four_bar(axis, rigid, stiffer=1.0, **rest):
    """The demo with an unsymmetric laminate, and the same with rigid links of that mass, centre of mass and inertia."""
    data = load("demos/composite_four_bar.toml").model_dump(by_alias=True, exclude_none=True)
    del data["masses"]["B"]
    plies = [{"thickness": 0.5e-3, "material": "along"}, {"thickness": 2e-3, "material": "aluminium"}]
    data["sections"]["laminate"] = {"shape": "laminate", "width": 0.025, "plies": plies, "axis": axis}
    for material in data["materials"].values():
        material["modulus"] *= stiffer
    data |= {"gravity": (3.0, -9.0), "mesh": {"elements": 2}} | rest
    line, neutral = 0.025 * (1600 * 0.5e-3 + 2714 * 2e-3), (140 * 0.125 + 71 * 3) / (140 * 0.5 + 71 * 2) * 1e-3
    beside = (1600 * 0.125 + 2714 * 3) / (1600 * 0.5 + 2714 * 2) * 1e-3 - (neutral if axis == "neutral" else 1.25e-3)
    if rigid:
        for name, length in (("coupler", 0.28), ("rocker", 0.26)):
            body = {"mass": line * length, "inertia": line * length**3 / 12, "centre": (length / 2, beside)}
            data["links"][name] = data["links"][name] | {"members": {}, "rigid": body}
        for unused in ("along", "across"):
            del data["materials"][unused]
        del data["sections"]["laminate"]
    return Scene.read(data)


def test_a_taper_in_another_link_changes_nothing_of_them():
    rest = {"analysis": {"method": "quasi-static", "sub_intervals": 6, "allow_coarse": True}}
    plain = four_bar("middle", False, **rest)
    data = plain.model_dump(by_alias=True, exclude_none=True)
    data["sections"]["thin"] = data["sections"]["bar"] | {"height": 6e-3}
    data["sections"]["taper"] = {"shape": "taper", "from": "bar", "to": "thin"}
    data["links"]["crank"]["members"]["OA"]["section"] = "taper"
    names = {"member": ["coupler", "rocker"]}  # statically determinate: their forces do not know the crank's stiffness
    found, expected = (analyse(scene).data["strain"].sel(names).to_numpy() for scene in (Scene.read(data), plain))
    assert np.allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


@BOTH
def test_links_weigh_and_swing_as_rigid_ones_with_that_centre_of_mass(axis):
    analysis = {"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True}
    beams, bodies = (analyse(four_bar(axis, rigid, analysis=analysis)).data for rigid in (False, True))
    for name in ("joint_force", "input_torque"):
        expected = bodies[name].to_numpy()
        assert np.allclose(beams[name], expected, rtol=0, atol=1e-10 * np.abs(expected).max()), name


def test_a_motor_feels_them_as_rigid_ones_with_that_centre_of_mass():
    analysis = {"method": "periodic", "sub_intervals": 16, "modes": 4, "stability": False, "allow_coarse": True}
    drive = {"joint": "O", "speed": 60.0, "motor": {"stiffness": 50.0, "damping": 0.1, "inertia": 1e-3}}
    rest = {"drive": drive, "effects": ("large-rotations",), "analysis": analysis, "stiffer": 1e5}
    beams, bodies = (analyse(four_bar("middle", rigid, **rest)).data for rigid in (False, True))
    twist = bodies["drive_twist"].to_numpy()
    assert np.allclose(
        beams["drive_twist"], twist, rtol=0, atol=5e-5 * np.abs(twist).max()
    )  # 1.5e-5: 16 steps, stiff links


@pytest.mark.parametrize("effects", [(), ("shear", "rotary-inertia")])
def test_nothing_pulls_or_bends_the_free_end_of_a_strip_that_vibrates(effects):
    # of all inertia along a strip the forces at its free end are the sum; 3e-5 is left of moments, with 6 elements 1e-6
    swing = {"joint": "A", "law": {"kind": "harmonics", "sine": [0.6]}, "period": 0.15}
    scene = strip(
        "middle",
        {"A": PIN},
        elements=3,
        drive=swing,
        effects=("coupling", "large-rotations", *effects),
        damping={"ratio": 0.02},
        analysis={"method": "periodic", "sub_intervals": 24, "modes": 3, "allow_coarse": True},
    )
    data = analyse(scene).data.sel(member="beam")
    for name in ("axial_force", "shear_force", "moment"):
        force = np.abs(data[name].transpose("s", ...).to_numpy())
        assert force[-1].max() < (1e-4 if name == "moment" else 1e-9) * force.max(), name


@pytest.mark.parametrize("axis", ["neutral", "middle"])
def test_lumps_do_not_know_offsets(axis):
    scene = strip(axis, {"A": WELD}, gravity=(GRAVITY, 0.0), effects=["lumped-mass"])
    words = r"sections\.strip: .*centre of mass .* m, beside .*'lumped-mass' does not know"
    with pytest.raises(SceneError, match=words):
        analyse(scene)
