"""Frequencies of beams and frames with textbook answers, each a scene that nothing drives; rates of convergence.

The exact frequencies are roots of the characteristic equations of Euler-Bernoulli beams, found to 1e-12 here and in no
other part of the package: closed forms (Blevins, Formulas for natural frequency and mode shape, 1979, table 8-1), or
the determinant of the end conditions of exact solutions in every member.
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import iv, jv, kv, yv

from fenics_mech.analysis import analyse
from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene, Weld
from tests.common import modes_of

E, RHO, LENGTH = 210e9, 7850.0, 0.8
THICK, THIN = (0.02, 0.004), (0.02, 0.003)  # width and height (m)
MODES = 3
WEDGE = {  # the taper again, typed as formulas
    "area": f"{THICK[0] * THICK[1]!r}*(1 - s/2)",
    "inertia": f"{THICK[0] * THICK[1] ** 3 / 12!r}*(1 - s/2)**3",
    "fibre": f"{THICK[1] / 2!r}*(1 - s/2)",
}
WELD, ROLLER, PIN = {"kind": "weld"}, {"kind": "slot"}, {"kind": "revolute"}


def stiffness(size):
    """EA, EI and rho A of a rectangle."""
    width, height = size
    return E * width * height, E * width * height**3 / 12, RHO * width * height


def structure(elements, links, joints, **rest):
    """Make a scene of links ``name: (points, members as (first, second, section))`` that nothing drives."""
    rectangle = {"shape": "rectangle", "width": THICK[0]}
    data = {
        "materials": {"steel": {"modulus": E, "density": RHO}},
        "sections": {
            "thick": rectangle | {"height": THICK[1]},
            "thin": rectangle | {"height": THIN[1]},
            "half": rectangle | {"height": THICK[1] / 2},
            "taper": {"shape": "taper", "from": "thick", "to": "half"},
            "no-taper": {"shape": "taper", "from": "thick", "to": "thick"},
            "wedge": {"shape": "variable"} | WEDGE,
        },
        "ground": {"points": {"A": (0, 0), "B": (0.6 * LENGTH, 0), "C": (LENGTH, 0)}},
        "links": {
            name: {
                "points": points,
                "members": {
                    a + b: {"ends": (a, b), "section": section, "material": "steel"} for a, b, section in members
                },
            }
            for name, (points, members) in links.items()
        },
        "joints": joints,
        "mesh": {"elements": elements},
        "analysis": {"modes": MODES, "method": "quasi-static"},
    }
    return Scene.read(data | rest)


def beam(elements, *, second="thick", masses=None, **joints):
    """Make a beam A-B-C with a node at 0.6 of its length; the joints hold its points to the ground's."""
    points = {"A": (0, 0), "B": (0.6 * LENGTH, 0), "C": (LENGTH, 0)}
    members = [("A", "B", "thick"), ("B", "C", second)]
    held = {at: kind | {"connect": (f"ground.{at}", f"beam.{at}")} for at, kind in joints.items()}
    return structure(elements, {"beam": (points, members)}, held, masses=masses or {})


def uniform(elements, *, section="thick", masses=None, **joints):
    points = {"A": (0, 0), "C": (LENGTH, 0)}
    held = {at: kind | {"connect": (f"ground.{at}", f"beam.{at}")} for at, kind in joints.items()}
    return structure(elements, {"beam": (points, [("A", "C", section)])}, held, masses=masses or {})


def clamped_too(scene, **joints):
    """Hold a beam at more points than a rigid body needs, which the check of the mobility refuses."""
    return scene.model_copy(update={"joints": scene.joints | joints})


def frame(elements, corner):
    """Make an L: up from the ground, then to the right. The corner is a weld of two links, or a point of one."""
    size = 0.6 * LENGTH, 0.4 * LENGTH
    foot = WELD | {"connect": ("ground.A", "post.A")}
    if corner == "weld":
        links = {
            "post": ({"A": (0, 0), "B": (0, size[0])}, [("A", "B", "thick")]),
            "arm": ({"B": (0, 0), "C": (size[1], 0)}, [("B", "C", "thin")]),
        }
        return structure(elements, links, {"A": foot, "B": WELD | {"connect": ("post.B", "arm.B")}})
    points = {"A": (0, 0), "B": (0, size[0]), "C": (size[1], size[0])}
    return structure(elements, {"post": (points, [("A", "B", "thick"), ("B", "C", "thin")])}, {"A": foot})


def roots(function, count, step):
    """First positive roots of a function, by its changes of sign over steps that are small beside their distance."""
    found, x = [], step
    while len(found) < count:
        if np.sign(function(x)) != np.sign(function(x + step)):
            found.append(brentq(function, x, x + step, xtol=1e-14 * x, rtol=1e-14))
        x += step
    return np.array(found)


def of_one_span(equation):
    """Exact frequencies (rad/s) of a uniform beam from its characteristic equation in beta L."""
    _, ei, rho_a = stiffness(THICK)
    return roots(equation, MODES, 0.05) ** 2 * np.sqrt(ei / rho_a) / LENGTH**2


def ends(size, length, omega):
    """u, w, slope, N, V, M of an exact solution at both ends of a member, ``(2, 6, 6 constants)``."""
    ea, ei, rho_a = stiffness(size)
    a, b = omega * np.sqrt(rho_a / ea), (omega**2 * rho_a / ei) ** 0.25
    found = np.zeros((2, 6, 6))
    for end, x in enumerate((0.0, length)):
        c, s, far, near = np.cos(b * x), np.sin(b * x), np.exp(b * (x - length)), np.exp(-b * x)
        axial = np.array([np.cos(a * x), np.sin(a * x)]), a * np.array([-np.sin(a * x), np.cos(a * x)])
        found[end, 0, :2], found[end, 3, :2] = axial[0], ea * axial[1]
        found[end, 1, 2:] = c, s, far, near
        found[end, 2, 2:] = b * np.array([-s, c, far, -near])
        found[end, 4, 2:] = -ei * b**3 * np.array([s, -c, far, -near])  # V = -EI w'''
        found[end, 5, 2:] = ei * b**2 * np.array([-c, -s, far, near])
    return found


def of_two_members(sizes, lengths, *, turn=0.0, start="clamped", middle="joined"):
    """Exact frequencies (rad/s) of two members end to end, the second turned; its far end is free."""
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.eye(6)  # from the second member's axes into the first's
    rotation[:2, :2] = rotation[3:5, 3:5] = [[c, -s], [s, c]]
    at_start = {"clamped": [0, 1, 2], "pinned": [0, 1, 5]}[start]
    largest = np.array([stiffness(size)[1] for size in sizes]).max()
    scale = np.array([1, 1, lengths[0], *([lengths[0] ** 3 / largest] * 2), lengths[0] ** 2 / largest])[:, None]
    # only bending is scaled: the axial rows are larger by (length/height)^2, which a determinant does not mind

    def determinant(omega):
        one, two = (ends(size, length, omega) * scale for size, length in zip(sizes, lengths))
        matrix = np.zeros((12, 12))
        matrix[:3, :6] = one[0][at_start]
        matrix[3:6, 6:] = two[1][3:]
        matrix[6:, :6], matrix[6:, 6:] = one[1], -rotation @ two[0]
        if middle == "supported":  # the shear force may jump, and w is zero
            matrix[10, :6], matrix[10, 6:] = one[1][1], 0.0
        return np.linalg.det(matrix)

    return roots(determinant, MODES, 2.0)


def of_wedge(left=0.5):
    """Exact frequencies (rad/s) of a clamped beam whose height falls linearly to `left` of that at the root.

    With z from 1 at the root to `left` at the tip, ``(z^3 w'')'' = k^2 z w`` has the solutions
    ``Z_1(2 sqrt(k z))/sqrt(z)``, Z being J, Y, I and K (Kirchhoff, 1879).
    """
    _, ei, rho_a = stiffness(THICK)
    bend = np.array([-1, -1, 1, 1])

    def conditions(z, k):
        x = 2 * np.sqrt(k * z)
        w = np.array([bessel(1, x) for bessel in (jv, yv, iv, kv)]) / np.sqrt(z)
        slope = np.sqrt(k) / z * np.array([-jv(2, x), -yv(2, x), iv(2, x), -kv(2, x)])
        return w, slope, z**2 * (bend * k * w - 2 * slope), bend * k * z**2 * slope  # w, w', z^3 w'', (z^3 w'')'

    def determinant(mu):
        k = mu / (1 - left) ** 2
        matrix = np.array([*conditions(1.0, k)[:2], *conditions(left, k)[2:]])
        return np.linalg.det(matrix / np.abs(matrix).max(axis=1, keepdims=True))

    return roots(determinant, MODES, 0.05) * np.sqrt(ei / rho_a) / LENGTH**2


MASS_RATIO = 0.7  # of the end mass to the beam's
END_MASS = MASS_RATIO * stiffness(THICK)[2] * LENGTH
TIP = {"tip": {"at": "beam.C", "mass": END_MASS}}
LENGTHS = 0.6 * LENGTH, 0.4 * LENGTH
CASES = {  # a scene by its number of elements per member, and exact frequencies
    "cantilever": (
        lambda n: uniform(n, A=WELD),
        lambda: of_one_span(lambda x: np.cos(x) + 1 / np.cosh(x)),
    ),
    "pinned-pinned": (
        lambda n: uniform(n, A=PIN, C=ROLLER),
        lambda: of_one_span(np.sin),
    ),
    "clamped-pinned": (
        lambda n: clamped_too(uniform(n, A=WELD), C=uniform(n, A=PIN, C=ROLLER).joints["C"]),
        lambda: of_one_span(lambda x: np.sin(x) - np.tanh(x) * np.cos(x)),
    ),
    "clamped-clamped": (
        lambda n: clamped_too(uniform(n, A=WELD), C=Weld(kind="weld", connect=("ground.C", "beam.C"))),
        lambda: of_one_span(lambda x: np.cos(x) - 1 / np.cosh(x)),
    ),
    "end mass": (
        lambda n: uniform(n, A=WELD, masses=TIP),
        lambda: of_one_span(
            lambda x: 1 / np.cosh(x) + np.cos(x) + MASS_RATIO * x * (np.cos(x) * np.tanh(x) - np.sin(x))
        ),
    ),
    "overhanging": (
        lambda n: beam(n, A=PIN, B=ROLLER),
        lambda: of_two_members((THICK, THICK), LENGTHS, start="pinned", middle="supported"),
    ),
    "stepped": (
        lambda n: beam(n, A=WELD, second="thin"),
        lambda: of_two_members((THICK, THIN), LENGTHS),
    ),
    "taper": (
        lambda n: uniform(n, A=WELD, section="taper"),
        of_wedge,
    ),
    "taper by formulas": (
        lambda n: uniform(n, A=WELD, section="wedge"),
        of_wedge,
    ),
    "welded frame": (
        lambda n: frame(n, "weld"),
        lambda: of_two_members((THICK, THIN), LENGTHS, turn=-np.pi / 2),
    ),
    "bent link": (
        lambda n: frame(n, "bent"),
        lambda: of_two_members((THICK, THIN), LENGTHS, turn=-np.pi / 2),
    ),
}


def omega(scene):
    return np.sort(modes_of(scene).modes.omega[0])


@pytest.mark.parametrize("case", CASES)
def test_frequencies_converge_with_the_fourth_power_of_the_element_size(case):
    make, exact = CASES[case]
    truth = exact()
    n = 12 if "taper" in case else 6  # many more elements meet the eigensolver's round-off, 1e-8
    coarse, fine = (omega(make(elements)) / truth - 1 for elements in (n, 2 * n))
    assert np.all(fine > 0)  # Rayleigh: from above
    assert np.all(fine < 1e-3)
    assert np.all(np.abs(np.log2(coarse / fine) - 4) < 0.15)


@pytest.mark.parametrize(
    ("case", "printed"),
    [
        ("cantilever", (3.5160, 22.034)),
        ("clamped-clamped", (22.373, 61.673)),
        ("clamped-pinned", (15.418, 49.965)),
        ("pinned-pinned", (9.8696, 39.478)),
        ("taper", (3.82378, 18.3173)),  # Hodges and Rutkowski, AIAA Journal 19 (1981)
    ],
)
def test_the_exact_frequencies_are_those_of_the_textbooks(case, printed):
    _, ei, rho_a = stiffness(THICK)
    found = CASES[case][1]()[:2] * LENGTH**2 / np.sqrt(ei / rho_a)
    assert np.allclose(found, printed, rtol=3e-5)


def test_two_like_members_in_line_are_one_span():
    # the determinant of the end conditions against the closed form
    assert np.allclose(of_two_members((THICK, THICK), LENGTHS), CASES["cantilever"][1](), rtol=1e-10)


def test_ritz_method_gives_the_frequencies_of_a_simply_supported_taper():
    scene = uniform(24, A=PIN, C=ROLLER, section="taper")
    found = 2 * np.pi * simply_supported_frequencies(scene, MODES)["beam"]
    assert np.allclose(omega(scene), found, rtol=3e-5)
    assert np.all(omega(scene) > found)
    uniform_one = simply_supported_frequencies(uniform(1, A=PIN, C=ROLLER), MODES)["beam"]
    assert np.allclose(
        simply_supported_frequencies(uniform(1, A=PIN, C=ROLLER, section="no-taper"), MODES)["beam"], uniform_one
    )


def swinging(elements, section):
    """Make an arm on a motor that swings it to and fro, and give its angular velocity and acceleration too."""
    swing, period, rate = 0.3, 0.25, 2 * np.pi / 0.25
    still = uniform(elements, A=WELD, section=section).model_dump(by_alias=True)
    still["joints"] = {"A": {"connect": ("ground.A", "beam.A")}}
    still["drive"] = {"joint": "A", "law": {"kind": "harmonics", "sine": [swing]}, "period": period}
    still["analysis"]["sub_intervals"] = 8
    scene = Scene.read(still)
    theta = scene.drive_angles(8)
    return scene, swing * rate * np.cos(theta), -swing * rate**2 * np.sin(theta)


@pytest.mark.parametrize("section", ["taper", "wedge"])
@pytest.mark.parametrize("elements", [1, 5])
def test_section_forces_of_a_swinging_taper_are_those_of_statics(section, elements):
    # the inertia of the rigid motion alone: exact on any mesh, as the element's equilibrium is
    scene, speed, acceleration = swinging(elements, section)
    data = analyse(scene).data.sel(member="beam")
    s = data["s"].to_numpy()
    ea, ei, rho_a = stiffness(THICK)
    # int_s^1 (1 - x/2) x dx, and int_s^1 (1 - x/2) x (x - s) dx
    first = (1 - s**2) / 2 - (1 - s**3) / 6
    second = (1 - s**3) / 3 - (1 - s**4) / 8 - s * first
    axial = rho_a * LENGTH**2 * speed[:, None] ** 2 * first
    moment = -rho_a * LENGTH**3 * acceleration[:, None] * second
    shear = rho_a * LENGTH**2 * acceleration[:, None] * first
    for name, expected in (("axial_force", axial), ("moment", moment), ("shear_force", shear)):
        assert np.allclose(data[name], expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    height = 1 - s / 2
    bending = -moment * THICK[1] / 2 / (ei * height**2)
    strain = axial / (ea * height) + bending
    assert np.allclose(data["strain"].sel(fibre="+"), strain, rtol=0, atol=5e-10 * np.abs(strain).max())


def test_deflection_of_a_swinging_taper_converges():
    _, ei, rho_a = stiffness(THICK)
    x, weight = np.polynomial.legendre.leggauss(40)
    x, weight = (1 + x) / 2, weight / 2
    first = (1 - x**2) / 2 - (1 - x**3) / 6
    curvature = ((1 - x**3) / 3 - (1 - x**4) / 8 - x * first) / (1 - x / 2) ** 3
    errors = []
    for elements in (8, 16):
        scene, _, acceleration = swinging(elements, "taper")
        tip = -rho_a * LENGTH**5 / ei * acceleration[2] * np.sum(weight * curvature * (1 - x))
        along = analyse(scene).data["deflection"].isel(theta=2).sel(member="beam", s=1).to_numpy()
        errors.append(abs(np.hypot(*along) / abs(tip) - 1))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.15)
    assert errors[1] < 1e-6


def test_a_structure_at_rest_carries_nothing():
    result = analyse(uniform(2, A=WELD))
    assert np.abs(result.data["strain"]).max() == 0
    assert result.data.sizes["theta"] == 1
    assert "input_torque" not in result.data


def test_a_structure_has_no_period():
    with pytest.raises(SceneError, match=r"analysis\.method: .*needs a drive"):
        analyse(uniform(2, A=WELD).changed(analysis__method="periodic"))


def test_a_structure_that_can_move_is_refused():
    # three parallel rollers count as three, and let the beam slide
    scene = beam(2, A=ROLLER, B=ROLLER, C=ROLLER)
    pushed = scene.changed(loads={"push": {"at": "beam.B", "force": (1.0, 0.0)}})
    with pytest.raises(SceneError, match=r"analysis\.method: nothing holds .* can move freely along .* in joint A"):
        analyse(pushed.changed(analysis__method="static"))


def test_outer_fibres_of_a_laminate_have_their_own_strain_and_modulus():
    plies = [{"thickness": 1e-3, "material": "steel"}, {"thickness": 3e-3, "material": "light"}]
    scene, speed, acceleration = swinging(2, "thick")
    data = scene.model_dump(by_alias=True)
    data["materials"]["light"] = {"modulus": E / 4, "density": RHO / 3}
    data["sections"]["thick"] = {"shape": "laminate", "width": 0.02, "plies": plies}
    data["sections"] = {"thick": data["sections"]["thick"]}
    found = analyse(Scene.read(data)).data.sel(member="beam").isel(s=0)
    # by the four equal layers: E, E/4, E/4, E/4 from the - side; the neutral line is 19/14 mm from it
    rho_a, ea, neutral = RHO * 0.02 * 2e-3, E * 0.02 * 1.75e-3, 19 / 14 * 1e-3
    layers = np.array([1, 0.25, 0.25, 0.25]) * (1e-3**3 / 12 + 1e-3 * ((np.arange(4) + 0.5) * 1e-3 - neutral) ** 2)
    ei = E * 0.02 * layers.sum()
    beside = 1.5e-3 - neutral  # of the centre of mass, by the layers' densities 1, 1/3, 1/3, 1/3
    axial = rho_a * (speed**2 * LENGTH**2 / 2 + acceleration * beside * LENGTH) / ea
    moment = -rho_a * acceleration * (LENGTH**3 / 3 + beside**2 * LENGTH)
    for fibre, place, modulus in (("+", 4e-3 - neutral, E / 4), ("-", -neutral, E)):
        strain = axial - moment * place / ei
        assert np.allclose(found["strain"].sel(fibre=fibre), strain, rtol=0, atol=1e-10 * np.abs(strain).max())
        assert np.allclose(
            found["stress"].sel(fibre=fibre), modulus * strain, rtol=0, atol=1e-10 * E * np.abs(strain).max()
        )
