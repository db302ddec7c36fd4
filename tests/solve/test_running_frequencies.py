"""Natural frequencies about a running motion by the core: against Ritz' method for turning beams, and at rest."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import about_motion, followed_modes, rigid_cycle
from tests.cases.test_running_frequencies import BODY, PLAIN, STRIP, column
from tests.cases.turning_beams import DENSITY, MODULUS, ritz, turning_beam
from tests.common import DEMOS


def running(scene, positions=8):
    """Frequencies at some positions (rad/s)."""
    scene = scene.changed({"effects": ("coupling", "large-rotations"), "damping": {}})
    machine, times = machine_of(scene).machine, np.zeros(1)
    if scene.drives:
        machine.chart = rigid_cycle(machine, scene.period)
        times = scene.period / positions * np.arange(positions)
    return about_motion(machine, times, followed_modes(machine, times))


@pytest.mark.parametrize("speed", [20.0, 120.0, -120.0])
@pytest.mark.parametrize(
    "beam",
    [
        PLAIN,
        PLAIN | {"mass": 0.3},
        BODY,
        BODY | {"rigid": True},
        BODY | {"rigid": True, "arm": -0.1},
        PLAIN | {"hub": 0.2},
        PLAIN | {"hub": -0.4},
        BODY | {"hub": 0.1, "rigid": True, "height": 0.005},
    ],
)
def test_turning_beams(speed, beam):
    """Ritz' beam does not stretch, which is 4e-4 at most here; twelve elements add 1e-4. No position is another."""
    expected = ritz(speed, **{key: value for key, value in beam.items() if key != "rigid"})[:2]
    found = np.sort(running(turning_beam(speed, **beam)), axis=1)[:, :2]
    np.testing.assert_allclose(found, np.tile(expected, (8, 1)), rtol=1e-3, atol=1e-6 * expected[-1])


@pytest.mark.parametrize(("rpm", "expected"), [(400, [4.673, 28.65]), (1600, [8.104, 66.15, 126.2])])
def test_rotating_strip(rpm, expected):
    """By Ritz' method and another code (Hz), without its load; 16 elements leave 1.3e-3 at 1600 rpm, eight 5e-3."""
    scene = fm.load(STRIP).changed(
        {"drive.speed": rpm * 2 * np.pi / 60, "loads": {}, "links.arm.members.OT.mesh.elements": 16}
    )
    mean = running(scene).mean(axis=0) / (2 * np.pi)
    assert mean[: len(expected)] == pytest.approx(expected, rel=2e-3)


def test_a_loaded_column_at_rest():
    """On two pins ``f = f_0 sqrt(1 - P/P_E)``; beyond the Euler load it diverges."""
    length, width, height = 0.5, 0.02, 0.004
    euler = np.pi**2 * MODULUS * width * height**3 / 12 / length**2
    first = np.sqrt(euler / (DENSITY * width * height)) * np.pi / length
    for share, expected in ((-1.0, np.sqrt(2)), (0.5, np.sqrt(0.5)), (1.1, 0.0)):
        found = running(column(share * euler, length, width, height))
        assert found[0, 0] / first == pytest.approx(expected, rel=1e-3)


def test_a_four_bar_as_by_link_frames():
    """Hz at three positions, 90 rad/s: by coordinates of link frames of an earlier release, in the 20 lowest modes."""
    scene = fm.load(DEMOS / "four_bar.toml").changed({"drive.speed": 90.0})
    found = np.sort(running(scene, 12)[[0, 3, 7], :3], axis=1) / (2 * np.pi)
    known = [[36.60305, 54.54539, 77.96536], [51.56096, 54.52389, 82.87083], [35.73341, 53.96703, 99.17182]]
    np.testing.assert_allclose(found, known, rtol=3e-4)


def test_few_modes_are_looked_at(monkeypatch):
    """Beyond them frequencies are those held."""
    monkeypatch.setattr("fenics_mech.solve.running_frequencies.MOST", 4)
    scene = turning_beam(120.0, **PLAIN).changed({"effects": ("coupling",), "damping": {}})
    machine, times = machine_of(scene).machine, np.zeros(1)
    machine.chart = rigid_cycle(machine, scene.period)
    held = followed_modes(machine, times)
    found = about_motion(machine, times, held)
    assert (np.abs(found / held.omega - 1)[0] > 1e-6).sum() == 4
