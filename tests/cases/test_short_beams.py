"""Frequencies of short beams: shear and rotary inertia act where they count, by their share of the frequencies."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from fenics_mech import cli, load, modes
from tests.common import DEMOS, ROOT

TUBE = ROOT / "tests" / "cases" / "scenes" / "short_tube.toml"
DIAMETER, BORE, MODULUS, DENSITY, POISSON = 30.08e-3, 7e-3, 210e9, 7850.0, 0.3
FIXED = {"free": [2, 3], "clamped": [0, 1], "pinned": [0, 2]}  # what is 0 of w, phi, M, Q


def cowper(poisson, ratio):
    """Cowper (1966) of a tube, by the ratio of its radii."""
    m2 = ratio**2
    outer = 6 * (1 + poisson) * (1 + m2) ** 2
    return outer / ((7 + 6 * poisson) * (1 + m2) ** 2 + (20 + 12 * poisson) * m2)


def timoshenko(length, first, last, count):
    """Frequencies (Hz) of a uniform tube by the transfer matrix of w, phi, M, Q.

    ``w' = phi + Q/(k G A), phi' = M/EI, M' = -Q - rho I omega^2 phi, Q' = -rho A omega^2 w``: the determinant of what
    must be 0 at the end, by what need not be 0 at the start, vanishes.
    """
    area, inertia = np.pi * (DIAMETER**2 - BORE**2) / 4, np.pi * (DIAMETER**4 - BORE**4) / 64
    shear = cowper(POISSON, BORE / DIAMETER) * MODULUS / (2 * (1 + POISSON)) * area
    bend, line, turn = MODULUS * inertia, DENSITY * area, DENSITY * inertia
    unit = np.array([length, 1.0, bend / length, bend / length**2])  # of w, phi, M, Q

    def determinant(omega):
        rates = np.zeros((4, 4))
        rates[0, 1], rates[0, 3], rates[1, 2] = 1, 1 / shear, 1 / bend
        rates[2, 3], rates[2, 1], rates[3, 0] = -1, -turn * omega**2, -line * omega**2
        whole = expm(length * rates * unit / unit[:, None])
        return np.linalg.det(whole[np.ix_(FIXED[last], np.setdiff1d(range(4), FIXED[first]))])

    slow, fast = (
        0.02 * np.sqrt(bend / line) / length**2,
        1.2 * ((count + 1) * np.pi / length) ** 2 * np.sqrt(bend / line),
    )
    grid = np.linspace(max(slow, fast / 1e4), fast, 4000)
    values = [determinant(omega) for omega in grid]
    roots = [brentq(determinant, a, b) for a, b, x, y in zip(grid, grid[1:], values, values[1:]) if x * y < 0]
    return np.array(roots[:count]) / (2 * np.pi)


def tube(length, supports, **changes):
    """A tube on supports at its ends, held at rest."""
    scene = load(TUBE).changed({"links.beam.points": {"A": [0, 0], "B": [length, 0]}, "analysis.modes": 8})
    ground = {"A": [0, 0], "B": [length, 0]}
    kinds = {"clamped": "weld", "pinned": "revolute"}
    joints = {
        point: {"kind": kinds[kind], "connect": [f"ground.{point}", f"beam.{point}"]}
        for point, kind in zip("AB", supports)
        if kind in kinds
    }
    return scene.changed({"ground": {"points": ground}, "joints": joints} | changes)


def bending(scene, count):
    """Frequencies of bending (Hz): along its axis the beam moves not across."""
    found = modes(scene).data.isel(theta=0)
    across = np.abs(found["shape"].sel(component="y")).max(("member", "s")).to_numpy() > 0.5
    return found["frequency"].to_numpy()[across & (found["frequency"].to_numpy() > 0)][:count], found


def test_the_reference_is_that_of_the_case():
    """The values of the case, with Cowper's 0.78391."""
    assert cowper(POISSON, BORE / DIAMETER) == pytest.approx(0.78391, rel=1e-4)
    assert timoshenko(0.3, "free", "free", 4) == pytest.approx([1535.3, 4028.6, 7416.6, 11415.9], rel=1e-4)


@pytest.mark.parametrize(
    ("length", "supports"),
    [
        (0.3, ("free", "free")),
        (0.3, ("clamped", "free")),
        (0.2, ("clamped", "clamped")),
        (0.3, ("pinned", "pinned")),
        (0.25, ("clamped", "pinned")),
        (0.5, ("free", "free")),
    ],
)
def test_short_tubes(length, supports):
    """There are twenty elements, of which the mesh error is told: up to 0.5 % of the third mode, as of order 2."""
    found, data = bending(tube(length, supports), 3)
    told = data["frequency_error"].to_numpy()[np.isin(data["frequency"].to_numpy(), found)]
    assert found / (1 + told) == pytest.approx(timoshenko(length, *supports, 3), rel=4e-4)
    assert told.max() < 6e-3
    assert set(data.attrs["decisions"].split(" act here")[0].split(" and ")) == {"shear", "rotary-inertia"}
    assert not data["theory_error"].any()


@pytest.mark.parametrize(("length", "supports"), [(0.3, ("free", "free")), (0.3, ("clamped", "free"))])
def test_the_theory_error_is_told_of_each_mode_where_effects_are_listed(length, supports):
    """To first order: a third off where it is 20 %."""
    found, data = bending(tube(length, supports, effects=()), 3)
    true = found / timoshenko(length, *supports, 3) - 1
    told = data["theory_error"].to_numpy()[np.isin(data["frequency"].to_numpy(), found)]
    assert told == pytest.approx(true, rel=0.35)


def test_a_heavy_mass_on_a_short_beam_counts_in_its_shear():
    """A light beam with a mass M at its end has ``omega^2 = 1/(M (L^3/3EI + L/(k G A)))``."""
    length = 0.06
    scene = tube(length, ("clamped", "free"), effects=(), masses={"m": {"at": "beam.B", "mass": 50.0}})
    area, inertia = np.pi * (DIAMETER**2 - BORE**2) / 4, np.pi * (DIAMETER**4 - BORE**4) / 64
    shear = cowper(POISSON, BORE / DIAMETER) * MODULUS / (2 * (1 + POISSON)) * area
    true = np.sqrt(1 + 3 * MODULUS * inertia / (shear * length**2)) - 1
    assert float(modes(scene).data["theory_error"][0]) == pytest.approx(true, rel=0.1)


def test_without_poissons_ratio_modes_says_what_it_takes(tmp_path, monkeypatch, capsys):
    short = tmp_path / "short.toml"
    short.write_text(TUBE.read_text().replace("poisson = 0.3\n", ""))
    monkeypatch.setattr("sys.argv", ["fenics-mech", "modes", str(short), "-o", str(tmp_path)])
    with pytest.raises(SystemExit):
        cli.main()
    said = " ".join(capsys.readouterr().out.split())
    assert "shear and rotary-inertia act here" in said
    assert "states neither `poisson` nor `shear_modulus`: shear takes a Poisson's ratio of 0.3" in said


@pytest.mark.slow
def test_a_four_bar_of_short_links():
    """Both act, as in each of its links; the demo itself is thin."""
    demo = load(DEMOS / "four_bar.toml").changed({"analysis.sub_intervals": 12})
    thin = modes(demo)
    assert thin.decisions == ()
    assert 0 < thin.data["theory_error"].max() < 5e-3
    bar = {"shape": "rectangle", "width": 0.03, "height": 0.04}
    thick = demo.changed({"sections": dict.fromkeys(demo.sections, bar), "materials.aluminium.poisson": 0.33})
    thick = thick.changed({"drive.speed": 5.0})  # at which their share of the strains is small
    found = modes(thick)
    assert found.decisions == ("shear and rotary-inertia act here: they change these frequencies by up to 4.4 %",)
    both = modes(thick.changed(effects=("shear", "rotary-inertia"))).data["frequency"]
    assert found.data["frequency"].to_numpy() == pytest.approx(both.to_numpy(), rel=1e-9)
    assert modes(thick.changed(effects=())).data["frequency"].min() > 1.01 * both.min()
