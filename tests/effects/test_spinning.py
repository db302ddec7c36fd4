"""Spinning and compressed beams: coupling and geometric stiffness against tables and closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from fenics_mech import modes
from fenics_mech.analysis import analyse
from fenics_mech.scene import Scene
from tests.common import modes_of

LENGTH, AREA, INERTIA, MODULUS, DENSITY = 1.0, 1e-4, 1e-10, 70e9, 2700.0
EI, LINE = MODULUS * INERTIA, DENSITY * AREA
UNIT = np.sqrt(EI / (LINE * LENGTH**4))  # rad/s
# In-plane frequencies of a cantilever on a hub of radius 0 over the speed, both in UNIT: out of plane they are those
# of Wright, Smith, Thresher and Wang, J. Appl. Mech. 49 (1982) 197, table 1; in the plane of turning their square is
# less by that of the speed.
OUT_OF_PLANE = {
    0: (3.5160, 22.0345, 61.6972),
    2: (4.1373, 22.6149, 62.2732),
    4: (5.5850, 24.2733, 63.9668),
    8: (9.2568, 29.9954, 70.2930),
}


def spinning(speed, offset=0.0, **rest):
    """A beam clamped to a crank that turns; its axis passes the pin at a distance."""
    return Scene.read(
        {
            "materials": {"metal": {"modulus": MODULUS, "density": DENSITY}},
            "sections": {"strip": {"area": AREA, "inertia": INERTIA, "fibre": 1e-3}},
            "ground": {"points": {"O": [0, 0]}},
            "links": {
                "hub": {"points": {"O": [0, 0], "A": [0, offset]}, "rigid": {"mass": 1.0, "inertia": 1.0}},
                "beam": {
                    "points": {"A": [0, 0], "B": [LENGTH, 0]},
                    "members": {"AB": {"ends": ["A", "B"], "section": "strip", "material": "metal"}},
                },
            },
            "joints": {
                "O": {"connect": ["ground.O", "hub.O"]},
                "A": {"kind": "weld", "connect": ["hub.A", "beam.A"]},
            },
            "drive": {"joint": "O", "speed": speed},
            "effects": ["coupling", "geometric-stiffness"],
            "mesh": {"elements": 16},
            "analysis": {"sub_intervals": 8, "modes": 3},
        }
        | rest
    )


def running(scene):
    """Frequencies about the motion (rad/s)."""
    return 2 * np.pi * np.sort(modes(scene).data["running_frequency"].to_numpy()[0])


@pytest.mark.parametrize("ratio", [2, 4, 8])
def test_frequencies_of_a_spinning_cantilever(ratio):
    found = running(spinning(ratio * UNIT))[:3]
    expected = np.sqrt(np.square(OUT_OF_PLANE[ratio]) - ratio**2)
    # mean axial force in each of 16 elements, h^2; Coriolis forces only act along the axis, which hardly stretches
    assert found / UNIT == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("stiffening", ["geometric-stiffness", "large-rotations"])
def test_disturbances_of_a_spinning_cantilever_have_these_frequencies(stiffening):
    speed = 4 * UNIT
    analysis = {"sub_intervals": 48, "modes": 6}
    scene = spinning(speed, damping={"material": 1e-6}, effects=["coupling", stiffening], analysis=analysis)
    found = analyse(scene).data["multiplier_frequency"].to_numpy()
    expected = np.sqrt(np.square(OUT_OF_PLANE[4][0]) - 16) * UNIT / (2 * np.pi)
    assert np.abs(found - expected).min() < 2e-3 * expected


@pytest.mark.parametrize("ratio", [0.5, 8, 20, 50])
def test_disturbances_that_turn_more_slowly_than_the_beam(ratio):
    """Their frequencies are in the beam's axes, and not those less or more by the speed; at 50, 10.3 and not 60.3."""
    scene = spinning(
        ratio * UNIT,
        damping={"material": 1e-7},
        mesh={"elements": 8},
        analysis={"sub_intervals": 96, "modes": 3},
    )
    expected = running(scene)[0] * np.ones(2)
    found = analyse(scene).data
    which = found["multiplier_mode"].to_numpy() == 1
    # the Coriolis forces left out on the right, of a beam that hardly stretches, take 2e-3 at 50 times the unit
    assert 2 * np.pi * found["multiplier_frequency"].to_numpy()[which][:2] == pytest.approx(expected, rel=3e-3)
    assert (found["multiplier_link"] == "beam").all()


def whirling(speed, disc, damping):
    """A mass amid a turning hub, on a strut as stiff across, ``3 EI/L^3``, as along, ``EA/L``: 1000 N/m for 1 kg.

    The mass is at the strut's node or, with a disc welded to it, at a pin, whose coordinates are along fixed axes.
    """
    length, area = 0.1, 1e-4
    hub = {"points": {"O": [0, 0], "A": [-length, 0]}, "rigid": {"mass": 1.0, "inertia": 1.0}}
    member = {"ends": ["A", "C"], "section": "strut", "material": "light"}
    strut = {"points": {"A": [-length, 0], "C": [0, 0]}, "members": {"AC": member}}
    of_disc = {"disc": {"points": {"C": [0, 0]}, "rigid": {"mass": 1.0, "inertia": 1e-7}}} if disc else {}
    welds = {"C": {"kind": "weld", "connect": ["strut.C", "disc.C"]}} if disc else {}
    return Scene.read(
        {
            "materials": {"light": {"modulus": 1e6, "density": 0.01}},
            "sections": {"strut": {"area": area, "inertia": area * length**2 / 3, "fibre": 1e-3}},
            "ground": {"points": {"O": [0, 0]}},
            "links": {"hub": hub, "strut": strut, **of_disc},
            "joints": {
                "O": {"connect": ["ground.O", "hub.O"]},
                "A": {"kind": "weld", "connect": ["hub.A", "strut.A"]},
                **welds,
            },
            "masses": {} if disc else {"m": {"at": "strut.C", "mass": 1.0}},
            "drive": {"joint": "O", "speed": speed},
            "effects": ["coupling"],
            "damping": {"material": damping} if damping else {},
            "mesh": {"elements": 1},
            "analysis": {"sub_intervals": 60, "modes": 2, "allow_unstable": True},
        }
    )


@pytest.mark.parametrize(
    ("share", "disc", "damping"), [(0.4, 0, 1e-5), (0.4, 0, 0), (0.3, 1, 0), (1.7, 0, 0), (5.3, 1, 1e-5)]
)
def test_whirl_of_an_isotropic_rotor(share, disc, damping):
    """It is at omega in fixed axes, and in turning ones at omega - speed forward and omega + speed backward.

    Both have one multiplier: their difference is twice the speed. Without damping any combination is an eigenvector.
    """
    omega = np.sqrt(1000.0)
    found = analyse(whirling(share * omega, disc, damping)).data
    slow = np.sort(2 * np.pi * found["multiplier_frequency"].to_numpy() / omega)[:4]
    # the strut has 3e-8 of the mass, and the disc an inertia, which at 5.3 takes 1e-4 of the stiffness
    assert slow == pytest.approx(np.repeat([abs(1 - share), 1 + share], 2), rel=2e-4)
    assert set(found["multiplier_link"].to_numpy()) == {"strut"}  # the link whose members move


def test_steady_deflection_of_a_spinning_beam_beside_the_centre():
    speed, offset = 5 * UNIT, 0.02
    scene = spinning(speed, offset, damping={"ratio": 0.02}, analysis={"sub_intervals": 8, "modes": 2})
    found = analyse(scene).data["deflection"].sel(member="beam").isel(s=-1).to_numpy()

    def rates(x, y):  # EI w'''' = (N w')' + LINE speed^2 (offset + w), N = LINE speed^2 (L^2 - x^2)/2
        pull = LINE * speed**2 * (LENGTH**2 - x**2) / 2
        bend = EI * y[2]
        across = LINE * speed**2 * (offset + y[0]) - LINE * speed**2 * x * y[1] + pull * bend / EI
        return np.stack([y[1], y[2], y[3], across / EI])

    def ends(a, b):
        return np.array([a[0], a[1], b[2], b[3]])

    x = np.linspace(0, LENGTH, 40)
    tip = solve_bvp(rates, ends, x, np.zeros((4, 40)), tol=1e-8).sol(LENGTH)[0]
    assert np.linalg.norm(found, axis=-1) == pytest.approx(abs(tip), rel=3e-3)  # h^2 of the mean axial forces


@pytest.mark.parametrize("stiffening", [(), ("geometric-stiffness",), ("large-rotations",)])
def test_steady_stretch_of_a_spinning_bar(stiffening):
    """Closed form: EA u'' + LINE speed^2 (x + u) = 0, u(0) = 0, u'(L) = 0 (Bhuta and Jones, J. Acoust. Soc. Am. 1963).

    The bar is soft enough to grow by 9 % at its tip, and deep enough not to bend. Linear elements have an error that
    falls with h^2: what is left of the tip's place after two extrapolations falls with h^6.
    """
    wave = 0.5  # speed L sqrt(density / modulus)
    speed = wave / LENGTH * np.sqrt(MODULUS / DENSITY)
    sections = {"strip": {"area": AREA, "inertia": AREA * (0.3 * LENGTH) ** 2, "fibre": 1e-3}}

    def found(elements):
        # steps are in axes at rest, which the bar turns in: 9e-5 with 8 of them
        effects, analysis = ("coupling", *stiffening), {"sub_intervals": 120, "stability": False}
        scene = spinning(speed, sections=sections, effects=effects, mesh={"elements": elements}, analysis=analysis)
        data = analyse(scene).data
        tip = np.linalg.norm(data["deflection"].sel(member="beam").isel(s=-1).to_numpy(), axis=-1)
        pull = np.linalg.norm(data["joint_force"].sel(joint="A").to_numpy(), axis=-1)
        return np.stack([tip, pull]).mean(axis=1), np.ptp(tip)

    values = []
    for elements in (4, 8, 16):
        value, change = found(elements)
        assert change < 1e-9 * value[0]  # it is steady
        values.append(value)
    exact = np.array([np.tan(wave) / wave - 1, MODULUS * AREA * (1 / np.cos(wave) - 1)]) * [LENGTH, 1]
    assert np.abs(values[-1] / exact - 1).max() < 1e-3
    once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(values)]
    assert (16 * once[1] - once[0]) / 15 == pytest.approx(exact, rel=1e-8)


def spun_up(elements, effects):
    """A beam that a drive turns from rest to 6 rad/s in 15 s, as in Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 855.

    The run-up is that of Kane, Ryan and Banerjee, J. Guidance 10 (1987) 139.
    """
    turned = "0.4 * (t ** 2 / 2 + (7.5 / pi) ** 2 * (cos(2 * pi * t / 15) - 1))"
    member = {"ends": ["O", "B"], "section": "bar", "material": "metal"}
    return Scene.read(
        {
            "materials": {"metal": {"modulus": 2.8e7, "density": 1.2}},
            "sections": {"bar": {"area": 1.0, "inertia": 5e-4, "fibre": 0.04}},
            "ground": {"points": {"O": [0, 0]}},
            "links": {"beam": {"points": {"O": [0, 0], "B": [10, 0]}, "members": {"OB": member}}},
            "joints": {"O": {"connect": ["ground.O", "beam.O"]}},
            "drive": {
                "joint": "O", "speed": 6.0, "run_up": 15.0, "run_up_law": {"kind": "expression", "formula": turned},
            },
            "effects": effects,
            "mesh": {"elements": elements},
            "analysis": {
                "method": "transient", "sub_intervals": 48, "cycles": 1, "settled": 0, "time_tolerance": 1e-4,
                "stations": 3, "allow_coarse": True,
            },
        }
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.slow
def test_spin_up_of_a_beam():
    """The tip lags by 0.574 at most, and in the end is stretched by ``LINE speed^2 L^3/(3 EA)`` of the axial forces.

    Figures of the paper show a lag of 0.57 to 0.58. Exudyn, with 8 geometrically exact elements and steps of 2 and
    1 ms, gives -0.57377 at 6.76 s, and -0.21727, -0.54357, -0.4602 and -0.1509 at 3, 6, 9 and 12 s.
    """
    data = analyse(spun_up(6, ("coupling", "large-rotations"))).data
    theta, time = data["theta"].to_numpy(), data["time"].to_numpy()
    x, y = data["deflection"].isel(member=0, s=-1).transpose("component", "theta").to_numpy()
    along, across = np.cos(theta) * x + np.sin(theta) * y, np.cos(theta) * y - np.sin(theta) * x
    assert time[np.abs(across).argmax()] == pytest.approx(6.76, abs=0.1)
    assert np.abs(across).max() == pytest.approx(0.57377, rel=4e-3)  # h^2 of mean axial forces: 6.6e-3 with 4 elements
    lag = np.interp([3.0, 6.0, 9.0, 12.0], time, across)
    assert lag == pytest.approx([-0.21727, -0.54357, -0.4602, -0.1509], rel=1e-2)
    steady = time > 15
    wave = 6 * np.sqrt(1.2 / 2.8e7)
    assert np.count_nonzero(steady) > 40
    # 5.143e-4; the beam goes on swinging by 0.0035, which without damping brings its tip nearer by 4e-7 in the mean
    assert along[steady].mean() == pytest.approx(np.tan(10 * wave) / wave - 10, rel=2e-3)
    assert np.abs(across[steady]).max() < 0.005


@pytest.mark.parametrize("share", [-1.0, 0.0, 0.5, 0.9, 0.999])
def test_frequency_of_a_compressed_beam_falls_to_zero_at_the_euler_load(share):
    euler = np.pi**2 * EI / LENGTH**2
    scene = Scene.read(
        {
            "materials": {"metal": {"modulus": MODULUS, "density": DENSITY}},
            "sections": {"strip": {"area": AREA, "inertia": INERTIA, "fibre": 1e-3}},
            "ground": {"points": {"A": [0, 0], "B": [LENGTH, 0]}},
            "links": {
                "beam": {
                    "points": {"A": [0, 0], "B": [LENGTH, 0]},
                    "members": {"AB": {"ends": ["A", "B"], "section": "strip", "material": "metal"}},
                }
            },
            "joints": {
                "A": {"connect": ["ground.A", "beam.A"]},
                "B": {"kind": "slot", "connect": ["ground.B", "beam.B"], "angle": 0.0},
            },
            "loads": {"press": {"at": "beam.B", "force": [-share * euler, 0]}},
            "effects": ["geometric-stiffness"],
            "mesh": {"elements": 12},
            "analysis": {"method": "static", "modes": 2},
        }
    )
    found = modes_of(scene).modes.omega[0]
    n = np.array([1, 2])
    expected = (n * np.pi / LENGTH) ** 2 * np.sqrt(EI / LINE * (1 - share / n**2))  # Timoshenko, section on axial force
    assert found == pytest.approx(expected, rel=1e-4 / (1 - min(share, 0.999)))  # h^4, magnified near the Euler load
