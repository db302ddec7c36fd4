"""Beams and shafts that turn: frequencies, whirl and its stability, against closed forms.

Sources: Wright, Smith, Thresher and Wang, J. Appl. Mech. 49 (1982) 197 (turning cantilever); Genta, Dynamics of
Rotating Systems (2005), chapters 2 and 3 (Jeffcott's rotor, gyroscopic splitting, rotating damping).
"""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import roots_legendre

import fenics_mech as fm
from fenics_mech.errors import UnstableError
from tests.space.machines import ORIGIN, X, Z, bar, body, scene

SLIM = {"shape": "rectangle", "height": 2e-3, "width": 2e-3}  # of a beam of 1 m: it hardly stretches
MADE = {"modulus": 200e9, "density": 8000.0, "poisson": 0.3}
UNIT = np.sqrt(200e9 * (2e-3) ** 4 / 12 / (8000.0 * 4e-6))  # rad/s: sqrt(E I/rho A) of 1 m


def exact(speed, lag, terms=14):
    """First frequency of a turning cantilever, E I = rho A = L = 1, by Galerkin's method with x^2 P_k."""
    x, g = roots_legendre(80)
    x, g = (x + 1) / 2, g / 2
    P = np.polynomial.legendre.Legendre
    w0, w1, w2 = [], [], []
    for k in range(terms):
        p = P.basis(k, domain=[0, 1])
        a, b, c = p(x), p.deriv(1)(x) + 0 * x, p.deriv(2)(x) + 0 * x
        w0.append(x * x * a)
        w1.append(2 * x * a + x * x * b)
        w2.append(2 * a + 4 * x * b + x * x * c)
    w0, w1, w2 = map(np.array, (w0, w1, w2))
    M = (w0 * g) @ w0.T
    K = (w2 * g) @ w2.T + speed**2 * ((w1 * g * (1 - x * x) / 2) @ w1.T) - lag * speed**2 * M
    s = 1 / np.sqrt(np.diag(M))
    return np.sqrt(eigh(s[:, None] * K * s, s[:, None] * M * s, eigvals_only=True)[0])


def turning(speed, count):
    """A cantilever on the axis of its drive."""
    return scene(
        {"arm": bar((0, 0, 0), (1, 0, 0), material="made")},
        {"O": {"connect": ("ground.O", "arm.A"), "axis": Z}},
        ground={"points": {"O": ORIGIN}},
        sections={"bar": SLIM},
        materials={"made": MADE},
        mesh={"elements": count},
        drive={"joint": "O", "speed": speed * UNIT},
        analysis={"positions": 72, "modes": 2, "multipliers": 8, "stations": 2, "allow_unstable": True},
    )


def modulo(frequency, speed):
    """Bring a frequency to that by which multipliers turn, which know it but for whole turns of the drive."""
    return np.abs((frequency + speed / 2) % speed - speed / 2)


def test_wright_and_others_print_the_same():
    """Their table: 3.5160, 4.1373, 7.3604 and 13.170 of the flapping, at 0, 2, 6 and 12."""
    found = [exact(speed, lag=False) for speed in (0, 2, 6, 12)]
    np.testing.assert_allclose(found, [3.5160, 4.1373, 7.3604, 13.1702], rtol=2e-5)


@pytest.mark.long
@pytest.mark.parametrize("speed", [2.0, 6.0])
def test_a_turning_cantilever_flaps_and_lags_as_its_closed_form(speed):
    """By Floquet multipliers: flapping and lagging are the two slowest disturbances, of order 4 by the mesh."""
    errors = []
    for count in (2, 4):
        data = fm.analyse(turning(speed, count)).data
        found = np.sort(np.asarray(data["multiplier_frequency"]) * 2 * np.pi / UNIT)[:2]
        errors.append(found / [exact(speed, lag=True), exact(speed, lag=False)] - 1)
        assert float(data["frequency"][0, 0]) * 2 * np.pi / UNIT == pytest.approx(3.5160, rel=2e-3)  # without spin
    first, second = np.abs(errors)
    assert second.max() < 1e-3
    assert np.log2(first / second).min() > 3.3
    extrapolated = (16 * np.array(errors[1]) - errors[0]) / 15
    assert np.abs(extrapolated).max() < 2e-4


LENGTH, SIDE, DISC = 0.6, 6e-3, 2.0  # m, m, kg
STIFFNESS = 192 * 207e9 * SIDE**4 / 12 / LENGTH**3  # of a shaft that is held at both ends
CRITICAL = np.sqrt(STIFFNESS / DISC)


def jeffcott(speed, off=1e-4, outer=4.0, inner=0.0, **analysis):
    """A shaft along X in two bearings that hold its direction, and a disc in its middle, off its axis."""
    light = {"modulus": 207e9, "density": 1e-3, "poisson": 0.3}
    middle = (LENGTH / 2, 0, 0)
    shaft = {
        "points": {"A": ORIGIN, "M": middle, "C": (LENGTH, 0, 0)},
        "members": {
            ends: {"ends": tuple(ends), "section": "bar", "material": "light", "up": Z, "elements": 1}
            for ends in ("AM", "MC")
        },
    }
    return scene(
        {
            "shaft": shaft,
            "disc": body({"M": middle}, DISC, (2e-3, 1e-3, 1e-3), (LENGTH / 2, 0, off)),
        },
        {
            "A": {"connect": ("ground.A", "shaft.A"), "axis": X},
            "C": {"connect": ("ground.C", "shaft.C"), "kind": "cylinder", "axis": X},
            "M": {"connect": ("shaft.M", "disc.M"), "kind": "weld"},
        },
        ground={"points": {"A": ORIGIN, "C": (LENGTH, 0, 0)}},
        sections={"bar": {"shape": "rectangle", "height": SIDE, "width": SIDE}},
        materials={"light": light},
        dampers={"outer": {"at": "shaft.M", "damping": outer}} if outer else {},
        damping={"material": inner},
        drive={"joint": "A", "speed": speed},
        analysis={"positions": 36, "modes": 0, "stations": 3, "multipliers": 6} | analysis,
    )


@pytest.mark.parametrize("share", [0.5, 0.95, 1.0, 1.05, 2.0])
def test_an_unbalanced_disc_whirls_as_jeffcott_says(share):
    """The radius is e W^2/sqrt((w^2 - W^2)^2 + (c W/m)^2), from below the critical speed to beyond it.

    Motions stay at 1e-3 of the length, so that stretching has no part: the far bearing lets the shaft slide.
    """
    outer, off, speed = 4.0, 1e-5, share * CRITICAL
    data = fm.analyse(jeffcott(speed, off, outer)).data
    radius = np.linalg.norm(np.asarray(data["deflection"].isel(member=0, s=-1)), axis=-1)
    by_hand = off * speed**2 / np.hypot(CRITICAL**2 - speed**2, outer * speed / DISC)
    np.testing.assert_allclose(radius, by_hand, rtol=2e-3)
    assert float(data["multiplier"].max()) < 1


def test_damping_in_a_shaft_makes_it_unstable_beyond_its_limit():
    """Rotating damping (Genta, section 3.6): stable below w (1 + c_outer/c_inner)."""
    outer, inner = 4.0, 4.0 / STIFFNESS  # as much damping in the shaft: its material's time is c/k
    for share, stable in ((1.9, True), (2.1, False)):
        made = jeffcott(share * CRITICAL, 1e-5, outer, inner)
        if stable:
            assert float(fm.analyse(made).data["multiplier"].max()) < 1
        else:
            with pytest.raises(UnstableError, match="grows by a factor"):
                fm.analyse(made)


def overhung(speed, count=1):
    """A light shaft along Z that is driven at its foot, and a disc at its end."""
    end = (0, 0, 0.3)
    return scene(
        {"shaft": bar((0, 0, 0), end, X, material="light"), "disc": body({"B": end}, 1.5, (6e-3, 6e-3, 11e-3), end)},
        {
            "A": {"connect": ("ground.A", "shaft.A"), "axis": Z},
            "B": {"connect": ("shaft.B", "disc.B"), "kind": "weld"},
        },
        ground={"points": {"A": ORIGIN}},
        sections={"bar": {"shape": "rectangle", "height": 8e-3, "width": 8e-3}},
        materials={"light": {"modulus": 207e9, "density": 1e-3, "poisson": 0.3}},
        mesh={"elements": count},
        drive={"joint": "A", "speed": speed},
        analysis={"positions": 72, "modes": 0, "stations": 2, "multipliers": 20, "allow_unstable": True},
    )


def test_a_disc_on_the_end_of_a_shaft_splits_its_frequencies():
    """Forward and backward whirl of m z'' + k11 z + k12 b = 0, I b'' - i J W b' + k12 z + k22 b = 0."""
    L, EI, speed = 0.3, 207e9 * 8e-3**4 / 12, 200.0
    k = np.linalg.inv([[L**3 / (3 * EI), L**2 / (2 * EI)], [L**2 / (2 * EI), L / EI]])
    mass, turning_ = np.diag([1.5, 6e-3]), np.diag([0, 11e-3]) * speed
    # z = exp(i w t): (k + w G - w^2 M) = 0
    whirl = np.linalg.eigvals(
        np.block([[np.zeros((2, 2)), np.eye(2)], [np.linalg.solve(mass, k), np.linalg.solve(mass, turning_)]])
    )
    data = fm.analyse(overhung(speed)).data
    found = modulo(np.abs(np.asarray(data["multiplier_frequency"])) * 2 * np.pi, speed)
    assert len({round(x) for x in np.abs(whirl)}) == 4  # they do split
    assert float(data["multiplier"].max()) < 1 + 1e-6
    for w in whirl.real:
        assert np.abs(found - modulo(w, speed)).min() < 1e-5 * abs(w)
    torsion = np.sqrt(207e9 / 2.6 * 0.140577 * 8e-3**4 / L / 11e-3)
    assert np.abs(found - modulo(torsion, speed)).min() < 1e-5 * torsion
