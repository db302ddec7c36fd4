"""Natural frequencies about the running motion: spin and axial forces are in them, and `modes` says by how much."""

import numpy as np
import pytest

from fenics_mech import analyse, cli, load, modes
from fenics_mech.scene import Scene
from tests.cases.turning_beams import DENSITY, MODULUS, ritz, turning_beam
from tests.common import ROOT

BODY = {"length": 0.3, "width": 0.02, "height": 0.003, "mass": 0.5, "arm": 0.15}
PLAIN = BODY | {"mass": 0.0, "arm": 0.0}
STRIP = ROOT / "tests" / "cases" / "scenes" / "rotating_strip.toml"


def running(scene):
    """Mean over the cycle (rad/s)."""
    return 2 * np.pi * modes(scene).data["running_frequency"].mean("theta").to_numpy()


@pytest.mark.parametrize(
    ("rpm", "expected"),
    [(400, [4.673, 28.65]), (1600, [8.104, 66.15, 126.2])],
)
def test_rotating_strip(rpm, expected):
    """By Ritz' method and another code. Eight elements under a tension that falls along them leave 4e-3 at 1600 rpm."""
    scene = load(STRIP).changed({"drive.speed": rpm * 2 * np.pi / 60, "analysis.sub_intervals": 16})
    assert running(scene)[: len(expected)] / (2 * np.pi) == pytest.approx(expected, rel=5e-3)


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
        PLAIN | {"hub": -0.4},  # it points to the axis: compression
        BODY | {"hub": 0.1, "rigid": True, "height": 0.005},
    ],
)
def test_turning_beams(speed, beam):
    """Ritz' beam does not stretch, which is 4e-4 at most here; twelve elements add 1e-4.

    With the body towards the axis the slowest diverges at 120 rad/s, and is not most like the slowest one held.
    """
    expected = ritz(speed, **{key: value for key, value in beam.items() if key != "rigid"})[:2]
    assert np.sort(running(turning_beam(speed, **beam)))[:2] == pytest.approx(expected, rel=1e-3)


def test_held_frequencies_with_a_rigid_tip_body_are_not_those_of_the_motion():
    """21.118 rad/s were printed at 20 rad/s: without the force on the arm; 26.371 and 43.985, 815.4 are right."""
    found = modes(turning_beam(20.0, **BODY, rigid=True)).data
    assert 2 * np.pi * found["frequency"].to_numpy()[:, 0] == pytest.approx(25.012 * np.ones(12), rel=1e-4)
    assert 2 * np.pi * found["running_frequency"].to_numpy()[:, 0] == pytest.approx(26.371 * np.ones(12), rel=1e-4)
    assert running(turning_beam(120.0, **BODY, rigid=True))[:2] == pytest.approx([43.985, 815.4], rel=3e-4)


def test_multipliers_with_a_rigid_tip_body_are_right_by_poses():
    """About the same motion as above: Ritz' 43.999 rad/s, less what stretching takes."""
    options = {"sub_intervals": 60, "solver": "poses", "error_estimates": False}
    scene = turning_beam(120.0, **BODY, rigid=True).changed(
        {"effects": ("coupling", "large-rotations")} | {f"analysis.{key}": value for key, value in options.items()}
    )
    found = analyse(scene).data
    assert 2 * np.pi * found["multiplier_frequency"].to_numpy()[0] == pytest.approx(43.985, rel=1e-3)


def test_a_loaded_column_at_rest():
    """On two pins ``f = f_0 sqrt(1 - P/P_E)``; beyond the Euler load it diverges."""
    length, width, height = 0.5, 0.02, 0.004
    euler = np.pi**2 * MODULUS * width * height**3 / 12 / length**2
    first = np.sqrt(euler / (DENSITY * width * height)) * np.pi / length / (2 * np.pi)
    for share, expected in ((0.0, np.nan), (-1.0, np.sqrt(2)), (0.5, np.sqrt(0.5)), (1.1, 0.0)):
        found = modes(column(share * euler, length, width, height)).data
        assert found["frequency"][0, 0] == pytest.approx(first, rel=1e-4)
        # eight elements; and the force shortens the column by 1e-4
        assert found["running_frequency"][0, 0] / first == pytest.approx(expected, rel=1e-3, nan_ok=True)


def column(force, length, width, height):
    """A column on a pin and a guide, at rest under a force along it."""
    member = {"ends": ["A", "B"], "section": "strip", "material": "steel", "mesh": {"elements": 8}}
    return Scene.read(
        {
            "materials": {"steel": {"modulus": MODULUS, "density": DENSITY}},
            "sections": {"strip": {"shape": "rectangle", "width": width, "height": height}},
            "ground": {"points": {"A": [0, 0], "G": [length, 0]}},
            "links": {"beam": {"points": {"A": [0, 0], "B": [length, 0]}, "members": {"AB": member}}},
            "joints": {
                "A": {"connect": ["ground.A", "beam.A"]},
                "B": {"kind": "slot", "connect": ["ground.G", "beam.B"]},
            },
            "loads": {"press": {"at": "beam.B", "force": [-force, 0.0]}} if force else {},
            "analysis": {"method": "static", "modes": 3},
        }
    )


def printed(scene, folder, monkeypatch, capsys):
    """What `fenics-mech modes` prints."""
    monkeypatch.setattr("sys.argv", ["fenics-mech", "modes", str(scene), "-o", str(folder)])
    with pytest.raises(SystemExit):
        cli.main()
    return " ".join(capsys.readouterr().out.split())


def test_modes_says_by_how_much_spin_and_axial_forces_change_frequencies(tmp_path, monkeypatch, capsys):
    """The table has both, and its caption the largest change: ``4.698/3.834 - 1``. Shear takes 1e-4 of mode 2."""
    said = printed(STRIP, tmp_path, monkeypatch, capsys)
    assert "spin and axial forces change them by up to 23 %;" in said
    assert "1 running 4.648 4.698 2 running 28.62 28.68" in said
    assert np.loadtxt(tmp_path / "running_frequencies.csv", delimiter=",", skiprows=1)[:, 1].max() < 4.7


def test_modes_tells_no_change_below_half_a_percent(tmp_path, monkeypatch, capsys):
    """At 20 rpm it is ``(1.193 - 1) (20/60)^2/3.834^2/2``, 7e-4; the load adds 6e-3 on the held strip."""
    slow = tmp_path / "slow.toml"
    slow.write_text(STRIP.read_text().replace("400 rpm", "20 rpm").replace('"1 N"', '"0.01 N"'))
    assert "running" not in printed(slow, tmp_path, monkeypatch, capsys)


def test_all_modes_are_not_looked_at():
    """Of 36 coordinates the lowest 30 are; the others are those held."""
    found = modes(turning_beam(120.0, **PLAIN).changed({"analysis.modes": "all"})).data
    share = np.abs(found["running_frequency"] / found["frequency"] - 1).max("theta").to_numpy()
    assert found.sizes["mode"] == 36
    assert share[0] > 0.01
    assert not share[30:].any()


@pytest.mark.parametrize("tip", [{"rigid": True}, {}])
def test_coordinates_along_fixed_axes_make_no_difference(tip):
    """A welded body's coordinates are along fixed axes, those of a member of the link along its own."""
    assert running(turning_beam(90.0, **BODY, **tip))[:3] == pytest.approx(ritz(90.0, **BODY)[:3], rel=1e-3)
