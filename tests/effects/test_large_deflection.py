"""Large deflections against textbook answers: buckled beams (Euler's elastica) and Duffing's backbone."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.special import ellipe, ellipk

from fenics_mech.analysis import analyse
from fenics_mech.errors import SolverError
from fenics_mech.scene import Scene

LENGTH, WIDTH, HEIGHT, MODULUS, DENSITY = 1.0, 0.02, 0.002, 70e9, 2700.0
EA, EI, LINE = MODULUS * WIDTH * HEIGHT, MODULUS * WIDTH * HEIGHT**3 / 12, DENSITY * WIDTH * HEIGHT
EULER = np.pi**2 * EI / LENGTH**2


def strut(axial=None, across=0.0, spring=None, elements=12, **rest):
    """A strip from a pin to a roller that an axial spring and an axial force hold, with a force across its middle."""
    half = {"section": "strip", "material": "metal"}
    data = {
        "materials": {"metal": {"modulus": MODULUS, "density": DENSITY}},
        "sections": {"strip": {"shape": "rectangle", "width": WIDTH, "height": HEIGHT}},
        "ground": {"points": {"A": [0, 0], "B": [LENGTH, 0], "C": [LENGTH + 1, 0]}},
        "links": {
            "beam": {
                "points": {"A": [0, 0], "M": [LENGTH / 2, 0], "B": [LENGTH, 0]},
                "members": {"left": {"ends": ["A", "M"], **half}, "right": {"ends": ["M", "B"], **half}},
            }
        },
        "joints": {
            "A": {"connect": ["ground.A", "beam.A"]},
            "B": {"kind": "slot", "connect": ["ground.B", "beam.B"], "angle": 0.0},
        },
        "mesh": {"elements": elements},
        "effects": ["large-rotations"],
        "analysis": {"method": "static"},
    }
    loads = {"push": {"at": "beam.M", "force": [0, across]}} if across else {}
    if axial:
        loads["press"] = {"at": "beam.B", "force": [-axial, 0]}
    if spring:
        data["springs"] = {"wall": {"between": ["beam.B", "ground.C"], "stiffness": spring}}
    return Scene.read(data | {"loads": loads} | rest)


def middle(result):
    return result.data["deflection"].sel(member="beam.left", component="y").isel(s=-1).to_numpy()


def elastica(slope):
    """Force over the Euler load, shortening and amplitude over the length, of a pinned strut: Love, section 263."""
    m = np.sin(slope / 2) ** 2
    k, e = ellipk(m), ellipe(m)
    return (2 * k / np.pi) ** 2, 2 - 2 * e / k, np.sqrt(m) / k


def test_strut_buckles_at_the_euler_load():
    # The deflection under a small force across grows like 1/(1 - P/P_E): Timoshenko and Gere, section 1.11
    across = 1e-5
    for share in (0.5, 0.9, 0.99):
        u = np.pi / 2 * np.sqrt(share)
        expected = across * LENGTH**3 / (48 * EI) * 3 * (np.tan(u) - u) / u**3
        found = middle(analyse(strut(share * EULER, across)))[0]
        assert found == pytest.approx(expected, rel=2e-4 / (1 - share))  # h^4 error of the Euler load, magnified


@pytest.mark.parametrize("effect", ["geometric-stiffness", "large-rotations"])
def test_a_strut_beyond_the_euler_load_is_refused(effect):
    # nothing holds the roller and nothing pushes across: the straight strut is an equilibrium, but no stable one
    with pytest.raises(SolverError, match="buckles at drive angle 0 deg"):
        analyse(strut(1.05 * EULER, effects=[effect]))


@pytest.mark.parametrize("slope", [0.1, 0.3, 0.6, 1.0])
def test_amplitude_of_a_buckled_strut(slope):
    # an axial spring much softer than the strut takes what the strut does not: the shortening is nearly given
    spring = 1000 * EULER / LENGTH
    force, shortening, amplitude = elastica(slope)
    stretch = force * EULER / EA
    axial = force * EULER + spring * LENGTH * (shortening + stretch)
    result = analyse(strut(axial, 1e-4 * EULER, spring))
    near = 3e-6 + 2e-6 / slope**2  # h^4, and the force that chooses the side
    assert abs(middle(result)[0]) == pytest.approx(LENGTH * amplitude, rel=near)
    assert result.data["rotation"].max().item() == pytest.approx(slope, rel=near)
    moment = np.abs(result.data["moment"]).max().item()
    assert moment == pytest.approx(force * EULER * LENGTH * amplitude, rel=10 * near)


def test_forced_duffing_oscillation_of_a_beam_between_pins():
    # With immovable ends the tension is the same all along, EA (pi a)^2/(4 L^2) for a half-wave of height a:
    # a'' + w0^2 a + g a^3 = F cos(W t), Nayfeh and Mook, section 7.5. Solved here by scipy's boundary value solver.
    w0 = np.pi**2 * np.sqrt(EI / LINE) / LENGTH**2
    g = np.pi**4 * EA / (4 * LINE * LENGTH**4)
    drive = 0.8 * w0
    radius = np.sqrt(EI / EA)
    force = 0.9 * w0**2 * radius  # of the half-wave
    line = force * LINE * np.pi / 4  # constant along the beam: its part in the half-wave is 4/pi of it

    def rates(t, y):
        return np.stack([y[1], force * np.cos(drive * t) - w0**2 * y[0] - g * y[0] ** 3])

    t = np.linspace(0, np.pi / drive, 60)  # half a cycle: a is symmetric about both its ends
    known = solve_bvp(rates, lambda a, b: np.array([a[1], b[1]]), t, [radius * np.cos(drive * t), 0 * t], tol=1e-8)
    crank = {
        "crank": {"points": {"O": [0, 0], "P": [0.1, 0]}, "rigid": {"mass": 1.0, "inertia": 1.0}},
    }
    base = strut(spring=1e4 * EA / LENGTH).model_dump(exclude_unset=True)
    base["ground"]["points"]["O"] = (0.0, 1.0)
    base["links"] |= crank
    base["joints"]["O"] = {"connect": ["ground.O", "crank.O"]}
    base["drive"] = {"joint": "O", "speed": drive}
    factor = {"kind": "harmonics", "cosine": [1.0]}
    base["loads"] = {
        f"line_{member}": {"member": f"beam.{member}", "line": [0, line], "factor": factor}
        for member in ("left", "right")
    }
    base |= {"mesh": {"elements": 4}, "analysis": {"sub_intervals": 60, "stability": False}}
    found = middle(analyse(Scene.read(base)))
    expected = known.sol(
        np.abs(
            (np.linspace(0, 2 * np.pi / drive, 60, endpoint=False) + np.pi / drive) % (2 * np.pi / drive)
            - np.pi / drive
        )
    )[0]
    assert np.abs(expected).max() > 1.2 * radius  # the cubic force is more than a quarter of the linear one
    # the uniform load moves the third half-wave too, by about 1/81 of its 1/3
    assert np.abs(found - expected).max() < 0.015 * np.abs(expected).max()


def shaken(amplitude, ratio):
    """The strip free to shorten, shaken across its middle at its first frequency, for that height of its half-wave."""
    first = np.pi**2 / LENGTH**2 * np.sqrt(EI / LINE)
    force = amplitude * ratio * first**2 * LINE * LENGTH  # of the one mode: F = 2 zeta w^2 (m L/2) a
    still = strut(across=force, elements=4)
    return still.changed(
        ground__points__O=(0, -1),
        links__wheel={"points": {"O": (0, 0)}, "rigid": {"mass": 1.0, "inertia": 1.0}},
        joints__O={"connect": ("ground.O", "wheel.O")},
        loads__push__factor={"kind": "harmonics", "cosine": (1.0,)},
        drive={"joint": "O", "speed": first},
        effects=("coupling", "large-rotations"),
        damping={"ratio": ratio},
        analysis={"sub_intervals": 60, "solver": "collocation", "stability": False},
    )


@pytest.mark.parametrize("share", [0.001, 0.01, 0.02])
def test_modal_damping_does_not_brake_shortening_without_stress(share):
    """At resonance a mode's height is that of its ratio, however far it bends: the axis shortens without stress.

    Damping of the axial modes' linear strain would take twice the power of the bending's at 0.02.
    """
    found = np.abs(middle(analyse(shaken(share * LENGTH, 0.02)))).max()
    assert found == pytest.approx(share * LENGTH, rel=0.02)
