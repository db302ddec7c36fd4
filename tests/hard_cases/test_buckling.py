"""Buckling, divergence and parametric instability: a strut pressed to 4 times its Euler load, and pulsating pressure.

Hard: the stiffness is next to singular at the Euler load and indefinite beyond; steps of an implicit scheme damp what
ought to grow. Right: below the load the textbook's amplification, to what the mesh makes of the Euler load; above it,
and in a tongue of Strutt's diagram, an error that names link or mode, and angle or frequency.
"""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ellipk, mathieu_a, mathieu_b

from fenics_mech import analyse
from fenics_mech.errors import SolverError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import load
from fenics_mech.scene.factories import four_bar, seed_four_bar
from tests.common import DEMOS, response_of

LENGTH, BENDING, LINE, ACROSS = 0.5, 206e9 * 0.02 * 0.002**3 / 12, 7850 * 0.02 * 0.002, 1e-3
AXIAL = 206e9 * 0.02 * 0.002
EULER = np.pi**2 * BENDING / LENGTH**2
OMEGA = np.pi**2 / LENGTH**2 * np.sqrt(BENDING / LINE)
ELEMENTS = 12
SOFTER = (np.pi / ELEMENTS) ** 4 / 720  # by so much the Euler load of a mesh of cubic elements is too large
SLOW = 1e-6  # s, of material damping, which goes with the bending stiffness alone
WAYS = {
    "static": {"analysis__method": "static"},
    "quasi-static": {"analysis__method": "quasi-static"},
    "collocation": {"analysis__solver": "collocation"},
    "harmonic-balance": {"analysis__solver": "harmonic-balance", "analysis__harmonics": 3},
    "in time": {
        "analysis__method": "transient",
        "analysis__start": "static",
        "analysis__cycles": 1,
        "analysis__settled": 0.0,
    },
}
LINEAR, NONLINEAR = ("geometric-stiffness",), ("large-rotations",)
BOTH = [(way, effects) for way in WAYS for effects in (LINEAR, NONLINEAR)]
CASES = [pair for pair in BOTH if pair != ("quasi-static", NONLINEAR)]


@pytest.fixture(scope="module")
def column():
    """The demo: a column on two pins, whose drive only gives the time in which its load pulsates."""
    return load(DEMOS / "pulsating_column.toml").changed(mesh__elements=ELEMENTS, analysis__stations=3)


def pressed(column, share, way, effects):
    """Press with a share of the Euler load that does not pulsate."""
    forces = {
        "loads__dead__force": (0, -share * EULER),
        "loads__pulse__force": (0, 0),
        "loads__push__line": (ACROSS, 0),
    }
    rest = {
        "drive__speed": 1.0,
        "analysis__sub_intervals": 16 if "balance" in way else 4,
        "analysis__allow_unstable": False,
    }
    return column.changed(effects=effects, **forces, **rest | WAYS[way])


@pytest.mark.slow
@pytest.mark.parametrize(("way", "effects"), CASES)
def test_amplification_up_to_the_euler_load(column, way, effects):
    """Timoshenko and Gere, Theory of Elastic Stability, section 1.3: a uniform load on a beam-column."""
    for share in (0.5, 0.99, 0.999):
        # pressed, it is shorter: of the axis before, the stiffness is EI/lambda^2 and the pressure acts by 1/lambda
        longer = 1 - share * EULER / AXIAL if effects == NONLINEAR else 1.0
        u = np.pi / 2 * np.sqrt(share * longer)
        expected = ACROSS * LENGTH**4 * longer**2 / (16 * BENDING * u**4) * (1 / np.cos(u) - 1 - u**2 / 2)
        scene = pressed(column, share, way, effects).changed(analysis__stability=False)
        found = response_of(scene).data["deflection"].sel(member="column", s=0.5)
        # the load across is so small that exact strains differ by 1e-6
        close = max(1.1 * SOFTER, 1e-4 * (way == "in time")) / (1 - share)  # steps in time leave 2.6e-5 of the first
        assert found.sel(component="x").to_numpy() == pytest.approx(expected, rel=close)


@pytest.mark.parametrize("share", [1.001, 1.1, 4.0])
@pytest.mark.parametrize(("way", "effects"), [pair for pair in CASES if pair[1] == LINEAR and pair[0] != "in time"])
def test_beyond_the_euler_load_link_or_mode_is_named(column, way, effects, share):
    """In time, where strains are exact, the strut bows."""
    equilibrium = r"link column (gives way|buckles)"
    motion = r"unstable.* mode 1, that of link column|link column buckles"
    periodic = way in ("collocation", "harmonic-balance")
    with pytest.raises(SolverError, match=motion if periodic else equilibrium):
        analyse(pressed(column, share, way, effects))


@pytest.mark.parametrize("slope", [0.5, 0.8, 1.1])
def test_beyond_the_euler_load_a_strut_bows_as_the_elastica(column, slope):
    """Love, Mathematical Theory of Elasticity, section 263. The load across chooses the side.

    Its elements are 7e-6 too stiff against buckling, which is ``8 * 7e-6 / slope^2`` of the bow.
    """
    modulus = np.sin(slope / 2) ** 2
    share, amplitude = (2 * ellipk(modulus) / np.pi) ** 2, np.sqrt(modulus) / ellipk(modulus)
    data = analyse(pressed(column, share, "static", NONLINEAR)).data
    bow = data["deflection"].sel(member="column", s=0.5, component="x").item()
    assert abs(bow) == pytest.approx(LENGTH * amplitude, rel=3e-4)
    assert float(data["rotation"].max()) == pytest.approx(slope, rel=3e-4)


@pytest.mark.parametrize(
    ("damping", "speed", "says", "buckles"),
    [
        ({"material": 1e7}, 32.3, "which is rounding. Look for damping far beyond stiffness or inertia", False),
        ({"ratio": 0.02}, 300.0, "There are answers up to 0.1[0-9]* of the load", True),
    ],
)
def test_only_axial_forces_make_a_link_buckle(damping, speed, says, buckles):
    """Both fail. Material damping that turns with the links makes the symmetric stiffness indefinite as well."""
    scene = seed_four_bar(effects=("coupling", "large-rotations"), damping=damping, drive__speed=speed)
    with pytest.raises(SolverError, match=says) as failed:
        analyse(scene.changed(analysis__sub_intervals=24, analysis__allow_coarse=True))
    assert ("buckles: under its axial forces" in str(failed.value)) == buckles


@pytest.mark.slow
def test_a_tap_on_a_strut_that_stands_straight_beyond_its_load(column):
    """Pressed to 3 times its Euler load until 67 ms after a tap that is lost beside the pressure: closed form.

    The bow died out in steps of a 40th of the cycle, in which it grows by e^8: 106 % off, at any tolerance.
    """
    share, blow, drag, firm, cycle = 3.0, 1e-10, 3.0, 1e-3, 2.0
    scene = pressed(column, share, "in time", NONLINEAR).changed(
        loads__dead__factor={"kind": "pulse", "start": 0.9 * np.pi, "end": np.pi * 16 / 15},
        loads__push__line=(0.0, 0.0),
        impulses={"tap": {"at": "column@0.5", "angle": np.pi, "impulse": (blow, 0.0)}},
        drive__speed=2 * np.pi / cycle,
        damping={"external": drag, "material": firm},
        mesh__elements=4,
        analysis__sub_intervals=30,
        analysis__time_tolerance=0.02,
        analysis__allow_coarse=True,
    )
    found = response_of(scene).data["deflection"].sel(member="column", s=0.5, component="x")[16]
    mode = np.array([[0.0, 1.0], [(share - 1) * OMEGA**2, -drag - firm * OMEGA**2]])
    assert found == pytest.approx((expm(mode * cycle / 30) @ [0, 2 * blow / (LINE * LENGTH)])[0], rel=1e-3)


SIZES = {"crank": 0.1, "coupler": 0.3, "follower": 0.28, "ground": 0.25}
THIN, THICK = ({"area": 4e-5 * k, "inertia": 9e-12 * k**3, "fibre": 8e-4 * k} for k in (1, 10))
WEIGHT = 0.01  # N/m
ALUMINIUM = {"modulus": 71e9, "density": 2714.0}
PINS = {"coupler": np.array([-1.0, 0.2]), "follower": np.array([1.0, 0.3])}  # forces at B that press it at all angles


def pressed_link(link, share, **analysis):
    """Give a slow four-bar that a force at B presses to a share of the link's Euler load, and the pressure over that.

    Coupler and follower have pins at both ends: they carry force and weight at B as a truss does.
    """
    length, rigidity = SIZES[link], ALUMINIUM["modulus"] * THIN["inertia"]
    scene = four_bar(
        **SIZES,
        sections=[THIN if name == link else THICK for name in ("crank", "coupler", "follower")],
        material=ALUMINIUM,
        speed=1e-2,
        effects=LINEAR,
        mesh={"elements": 4},
        loads={"across": {"member": link, "line": (0, WEIGHT), "axes": "member"}},
        analysis={"sub_intervals": 6, "allow_coarse": True, "stations": 3, "stability": False} | analysis,
    )
    motion = solve_motion(scene, scene.drive_angles(6))
    axes = np.stack([np.stack([np.cos(angle), np.sin(angle)]) for angle in motion.angle[:, 1:].T]).transpose(2, 1, 0)
    i = list(SIZES).index(link) - 1
    normal = np.stack([-axes[:, 1, i], axes[:, 0, i]], axis=-1)
    towards = -np.linalg.inv(axes)[:, i]  # pressure by a force at B
    by_force, by_load = towards @ PINS[link], (towards * normal).sum(axis=1) * WEIGHT * length / 2
    euler = np.pi**2 * rigidity / length**2
    size = ((share * euler - by_load) / by_force).min()
    press = {"at": "B", "force": tuple(size * PINS[link])}
    return scene.changed(loads__press=press), (size * by_force + by_load) / euler, normal


@pytest.mark.parametrize("way", [{"method": "quasi-static"}, {"solver": "collocation"}])
@pytest.mark.parametrize("link", PINS)
def test_pressed_link_of_a_four_bar(link, way):
    """It bows against its chord as a beam-column on two pins, at all positions; above its Euler load it is named."""
    scene, shares, normal = pressed_link(link, 0.98, **way)
    assert shares.max() == pytest.approx(0.98)
    assert 0 < shares.min() < 0.6
    d = analyse(scene).data["deflection"].sel(member=link)
    bow = ((d.sel(s=0.5) - d.sel(s=0.0) / 2 - d.sel(s=1.0) / 2).to_numpy() * normal).sum(axis=1)
    u = np.pi / 2 * np.sqrt(shares)
    length, rigidity = SIZES[link], ALUMINIUM["modulus"] * THIN["inertia"]
    expected = WEIGHT * length**4 / (16 * rigidity * u**4) * (1 / np.cos(u) - 1 - u**2 / 2)
    softer = (np.pi / 4) ** 4 / 720 + 1e-4  # of the mesh, and of a rigid linkage's axial forces in an elastic one
    assert (np.abs(bow / expected - 1) * (1 - shares)).max() < softer
    with pytest.raises(SolverError, match=rf"link {link} (gives way|bends most|buckles)"):
        analyse(pressed_link(link, 1.002, **way)[0])


def pulsating(column, speed):
    """The column as Mathieu's equation; a trace of material damping makes the multipliers of mode 1 the largest."""
    few = {
        "mesh__elements": 12,
        "analysis__modes": 1,
        "analysis__sub_intervals": 30,
        "damping": {"material": SLOW},
    }
    return column.changed(drive__speed=speed, analysis__allow_unstable=False, **few)


def parameters(speed):
    """Give a and q of ``x'' + (a - 2 q cos 2t) x = 0``, for both forces 32.5 N."""
    return 4 * OMEGA**2 * (1 - 32.5 / EULER) / speed**2, 2 * OMEGA**2 * 32.5 / EULER / speed**2


def multiplier(speed):
    """That with the larger magnitude, and the decay of both, by Hill's determinant: Whittaker and Watson, 19.42."""
    a, q = parameters(speed)
    beside = q / ((2.0 * np.arange(-30, 31)) ** 2 - a)
    whole = np.eye(61) + np.diag(beside[:-1], 1) + np.diag(beside[1:], -1)
    half = 1 - np.linalg.det(whole) * (1 - np.cos(np.pi * np.sqrt(a)))
    decay = np.exp(-SLOW * OMEGA**2 * np.pi / speed)
    return decay * (half + np.sign(half) * np.sqrt(max(half**2 - 1, 0)) + 1j * np.sqrt(max(1 - half**2, 0)))


def border(which):
    """Speed at which a curve of Strutt's diagram is met: a_1 and b_1 hold the principal tongue."""
    first = 2 * OMEGA * np.sqrt(1 - 32.5 / EULER)

    def lack(speed):
        a, q = parameters(speed)
        return float(which(1, q)) - a

    return brentq(lack, 0.8 * first, 1.25 * first, xtol=1e-10)


def found_at(scene):
    data = response_of(scene).data.isel(disturbance=0)
    assert data["multiplier_mode"] == 1
    real, imaginary = data["multiplier"].to_numpy()
    return real + 1j * abs(imaginary)


@pytest.mark.parametrize(("which", "inside"), [(mathieu_b, -1), (mathieu_a, 1)])
def test_tongue_at_its_border(column, which, inside):
    """At 1e-3 and 1e-4 from it: what grows inside is named, with half the frequency of the force."""
    at = border(which)
    for off in (1e-4, 1e-3):
        within, beyond = at * (1 + inside * off), at * (1 - inside * off)
        assert abs(multiplier(within)) > 1 > abs(multiplier(beyond))
        frequency = rf"{within / (4 * np.pi):.4g} Hz"
        with pytest.raises(SolverError, match=rf"unstable: .* at {frequency}, mostly in mode 1, that of link column"):
            analyse(pulsating(column, within))
        assert found_at(pulsating(column, beyond)) == pytest.approx(multiplier(beyond), abs=1e-3)


def test_multipliers_inside_the_tongue_and_far_outside(column):
    low, high = border(mathieu_a), border(mathieu_b)
    for speed in (low * 0.7, low * 0.95, (low + high) / 2, high * 0.98, high * 1.05, high * 1.5):
        scene = pulsating(column, speed).changed(analysis__allow_unstable=True)
        assert found_at(scene) == pytest.approx(multiplier(speed), abs=1e-4)
