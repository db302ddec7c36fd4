"""Summaries and tables say the right numbers and fit the screen."""

import io
import re

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from fenics_mech.analysis import analyse
from fenics_mech.errors import SceneError
from fenics_mech.machine.reach import reachable_range
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import between_positions, doubts
from fenics_mech.scene import Scene, load
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views.animation import animate
from fenics_mech.views.details import details
from fenics_mech.views.frequency_views import frequency_table, write_frequencies
from fenics_mech.views.result_figures import plot_all
from fenics_mech.views.summary import summary
from fenics_mech.views.tables import scene_overview
from fenics_mech.views.words import share
from tests.common import DEMOS
from tests.demos.machines import crane
from tests.validation.__main__ import check_table
from tests.validation.check import Finding


def printed(renderable, width=80):
    """Give the text as printed at a width, and see that nothing was cut."""
    console = Console(file=io.StringIO(), width=width)
    console.print(renderable)
    text = console.file.getvalue()
    assert "\N{HORIZONTAL ELLIPSIS}" not in text
    assert max(map(len, text.splitlines())) <= width
    return text


def row(text, name):
    """Cells of the row that begins with a name."""
    return next(line.split() for line in text.splitlines() if line.split()[:1] == [name])


def test_peaks_of_the_members(result):
    text = printed(details(result))
    result = between_positions(result)  # of which there are 24
    strain = result.data["strain"].sel(member="follower")
    stress = result.data["stress"].sel(member="follower").to_numpy()  # with modal damping not E times the strain
    place = np.unravel_index(np.abs(stress).argmax(), stress.shape)
    cells = row(text, "follower")
    assert float(cells[1]) == pytest.approx(1e6 * float(strain[place]), rel=1e-3)
    assert float(cells[2]) == pytest.approx(1e-6 * stress[place], rel=1e-3)
    angle = np.degrees(float(result.data["theta"][place[0]]))
    assert cells[3].rstrip("\N{DEGREE SIGN},") == f"{angle:.0f}"
    assert float(cells[4].rstrip(",")) == pytest.approx(float(result.data["s"][place[1]]))
    assert cells[5] == "+\N{MINUS SIGN}"[place[2]]
    bent = np.linalg.norm(result.data["deflection"].sel(member="follower"), axis=-1).max()
    assert float(cells[6]) == pytest.approx(1e3 * bent, rel=1e-3)


def test_a_summary_is_text_where_it_is_printed(result):
    assert str(summary(result)) == printed(summary(result))
    assert str(summary(result, details=True)) == printed(details(result))


def test_harmonics_and_vibration_of_the_members():
    result = analyse(seed_four_bar(analysis={"sub_intervals": 96, "modes": 2, "allow_coarse": True}))
    text = printed(details(result))
    table = text[text.index("Strain at mid-span") :]
    amplitude = result.data["strain_amplitude"].sel(member="coupler", gauge="mid-span").to_numpy()[1:]
    cells = row(table, "coupler")
    assert cells[1] == f"{1 + amplitude.argmax()}:"
    assert float(cells[2].rstrip(",")) == pytest.approx(1e6 * amplitude.max(), rel=1e-2)
    frequency = float(result.data["vibration_frequency"].sel(member="coupler"))
    assert float(cells[-2]) == pytest.approx(frequency, rel=1e-3)
    assert float(cells[-1]) == float(result.data["vibration_mode"].sel(member="coupler"))


def test_joints_torque_frequencies_and_decisions(result):
    text = printed(details(result))
    close = between_positions(result).data
    force = np.linalg.norm(close["joint_force"].sel(joint="O"), axis=-1)
    assert float(row(text, "O")[1]) == pytest.approx(force.max(), rel=1e-3)
    assert row(text, "O")[3] == f"{np.degrees(float(close['theta'][force.argmax()])):.0f}\N{DEGREE SIGN}"
    torque = close["input_torque"].to_numpy()
    assert float(row(text, "input")[2]) == pytest.approx(torque[np.abs(torque).argmax()], rel=1e-3)
    frequency = result.data["frequency"].sel(mode=2).to_numpy()
    assert [float(cell) for cell in row(text, "2")[1:3]] == pytest.approx([frequency.min(), frequency.max()], rel=1e-3)
    for decision in (
        "32.3 rad/s",
        "24 positions",
        "physical",
        "2 kept",
        "2 % of critical in each mode",
        "9 elements, 27 degrees",
    ):
        assert decision in text


def test_a_quasi_static_result_has_no_modes():
    analysis = {"method": "quasi-static", "sub_intervals": 8, "allow_coarse": True}
    scene = seed_four_bar(analysis=analysis, mesh={"elements": 2})
    text = printed(details(analyse(scene)))
    assert "quasi-static, 8 positions" in text
    assert "6 elements" in text
    assert "Natural frequencies" not in text


def test_frequency_table_and_csv(result, tmp_path):
    frequency, theta = result.data["frequency"].to_numpy(), result.data["theta"].to_numpy()
    assert 0 < result.data["frequency_error"][0] < result.data["frequency_error"][1] < 0.1
    off, assurance = np.array([0.0123, 0.2]), result.data["assurance"].to_numpy()
    text = printed(frequency_table(frequency, assurance, off, {"coupler": 47.56}))
    assert float(row(text, "1")[1]) == pytest.approx(frequency[:, 0].min(), rel=1e-3)
    assert row(text, "1")[3:5] == ["1.2", "%"]
    assert row(text, "2")[3:6] == ["20%", "or", "more"]
    assert row(text, "coupler")[-1] == "47.56"
    assert "mesh error: share" in text
    path = write_frequencies(theta, frequency, tmp_path / "frequencies.csv")
    assert path.read_text().splitlines()[0] == "theta_rad,mode_1_Hz,mode_2_Hz"
    assert np.loadtxt(path, delimiter=",", skiprows=1) == pytest.approx(np.column_stack([theta, frequency]))


def test_check_table_says_what_holds_and_what_fails():
    text = printed(check_table([Finding("a [b]", "1e-13", "<= 1e-12", True), Finding("c", "2", "1", False)]))
    assert "a [b]" in text
    assert row(text, "a")[-1] == "holds"
    assert row(text, "c")[-1] == "FAILS"


def test_overview_of_scene_files(tmp_path, demo_text):
    file = tmp_path / "scene.toml"
    file.write_text(demo_text)
    scene = load(file)
    text = printed(scene_overview(scene, reachable_range(scene)))
    assert row(text, "coupler") == ["coupler", "0.2794", "strip", "aluminium", "3"]
    in_si = text.split("The same in SI")[1]  # 0.406 cm^2 and 8.67e-4 cm^4 of 71 GPa and 2714 kg/m^3
    assert row(in_si, "coupler") == ["coupler", "0.03079", "2.883e+06", "0.6156", "0.4621"]
    assert text.splitlines()[1].startswith("3 links, 4 joints, 2 point masses; joint O at")
    assert "mass A: 0.0452 kg at crank.A" in text
    assert "turns through the whole cycle. Mobility 1 by Gruebler's count." in text.replace("\n", " ")
    file.write_text(
        demo_text.replace('"11 in"', '"8 in"').replace('"10.65 in"', '"6 in"')
    )  # the crank cannot turn all the way
    scene = load(file)
    assert "dead centre" in printed(scene_overview(scene, reachable_range(scene)))
    with pytest.raises(SceneError):
        load(tmp_path / "lost.toml")


def test_overview_tells_rigid_links_springs_dampers_and_weight(seed):
    ends, follower = {"between": ("follower.B", "ground.O")}, seed.links["follower"]
    scene = seed.changed(
        gravity=(0.0, -9.81),
        links=seed.links | {"follower": {"points": follower.points, "rigid": {"mass": 0.3}, "angle": follower.angle}},
        masses={"A": {"at": "crank.A", "mass": 0.1}},
        springs={"s": {**ends, "stiffness": 40.0, "length": 0.2}, "h": {"joint": "C", "stiffness": 0.5}},
        dampers={"d": {**ends, "damping": 2.0}, "b": {"joint": "C", "damping": 0.001}},
    )
    text = " ".join(printed(scene_overview(scene, reachable_range(scene))).split())
    assert "3 links, 4 joints, 1 point mass; " in text
    assert "rigid link follower: 0.3 kg and 0 kg m^2, centre of mass (0, 0) m" in text
    assert "spring s: 40 N/m from follower.B to ground.O, free length 0.2 m" in text
    assert "spring h: 0.5 N m/rad at joint C, free angle as at drive angle 0" in text
    assert "damper d: 2 N s/m from follower.B to ground.O" in text
    assert "damper b: 0.001 N m s/rad at joint C" in text
    assert "gravity: (0, -9.81) m/s^2" in text


def test_a_structure_that_nothing_drives_is_summarised_and_drawn(tmp_path):
    half = {"section": "strip", "material": "metal"}
    scene = Scene.read(
        {
            "materials": {"metal": {"modulus": 70e9, "density": 2700.0}},
            "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.002}},
            "ground": {"points": {"A": [0, 0]}},
            "links": {"beam": {"points": {"A": [0, 0], "B": [1, 0]}, "members": {"AB": {"ends": ["A", "B"], **half}}}},
            "joints": {"A": {"kind": "weld", "connect": ["ground.A", "beam.A"]}},
            "loads": {"push": {"at": "beam.B", "force": [0, 0.1]}},
            "effects": "auto",
            "analysis": {"method": "static"},
        }
    )
    result = analyse(scene)
    text = printed(details(result))
    assert "no drive" in text
    assert "input torque" not in text
    assert plot_all(result, tmp_path) == []
    assert animate(result, tmp_path / "beam.png").stat().st_size > 1000


def test_peaks_between_positions_do_not_swing_beyond_corners():
    """A press that is on for 57 deg with flanks of 11 deg, at 36 positions: a Fourier series told up to 16 % more."""
    pulse = {"kind": "pulse", "start": 1.0, "end": 2.0, "ramp": 0.2}
    press = {"press": {"at": "coupler@0.5", "force": (0.0, -30.0), "factor": pulse}}
    analysis = {"solver": "collocation", "stability": False, "allow_coarse": True, "sub_intervals": 36}
    scene = seed_four_bar(effects=("coupling",), loads=press, drive__speed=5.0, analysis=analysis)
    few, many = (analyse(scene.changed(analysis__sub_intervals=count)) for count in (36, 240))
    assert "Peaks between the 36 positions are uncertain by an" in printed(details(few))
    assert max(doubts(many).values()) < 0.02  # the crank, of small strains: 0.9 % off against 1440 positions
    for name in ("strain", "joint_force", "deflection"):
        told, exact = (abs(found.data[name]).max() for found in (between_positions(few), many))
        assert told < 1.01 * exact


def test_doubt_about_peaks_does_not_rest_on_the_position_at_0(result):
    """A peak between the first two of 24 positions, of which 10 % are missed, and by every second one 29 % more."""
    peak = np.exp(-4 * np.sin((result.data["theta"] - np.radians(5)) / 2) ** 2 / np.radians(15) ** 2)
    curves = {name: 1e-4 * peak * xr.ones_like(result.data[name]) for name in ("strain", "joint_force")}
    unknown = result.data.drop_sel(source="positions")  # by which no error between positions is estimated
    text = " ".join(printed(details(Result(unknown.assign(curves)))).split())
    assert "Peaks between the 24 positions are uncertain by an estimated 28." in text
    assert "Take more sub_intervals" in text
    by_tolerance = unknown.assign(curves).assign_attrs(chosen="")  # which takes the positions itself
    assert "Take a smaller tolerance" in " ".join(printed(details(Result(by_tolerance))).split())


def test_a_drive_along_a_slide_gives_a_force():
    found = analyse(crane().changed(analysis__method="quasi-static", analysis__sub_intervals=36))
    assert found.data["input_torque"].attrs["units"] == found.data["drive_effort"].attrs["units"] == "N"
    line = next(line for line in printed(details(found)).splitlines() if line.startswith(" drive force"))
    peak = np.abs(found.data["input_torque"]).max()
    assert abs(float(line.split()[2])) == pytest.approx(float(peak), rel=0.02)
    assert line.split()[3] == "N"
    assert "N m" not in line


def test_springs_at_a_joint_give_a_moment():
    line = {"between": ("follower.B", "ground.O"), "stiffness": 40.0, "length": 0.2}
    hinge = {"joint": "C", "stiffness": 0.1}
    scene = seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24})
    for springs, unit in (({"a": line}, "N"), ({"a": hinge}, "N m"), ({"a": line, "b": hinge}, "N, N m")):
        assert analyse(scene.changed(springs=springs)).data["spring_force"].attrs["units"] == unit


def test_balance_of_energy_is_told():
    analysis = {"sub_intervals": 120, "stability": False, "stations": 3}
    scene = seed_four_bar(effects=("coupling",), damping={"material": 1e-3}, analysis=analysis)
    result = analyse(scene)
    drive, lost = (1e3 * float(result.data["mean_power"].sel(cause=name)) for name in ("drive", "material"))
    text = " ".join(printed(details(result)).split())
    assert f"Mean power over the cycle: drive {drive:.4g} mW, material {lost:.4g} mW; imbalance " in text
    assert "of the largest)." in text
    still = analyse(scene.changed(effects=(), analysis__method="quasi-static"))
    assert "is no error: the equation leaves out the coupling, and with it this power." in " ".join(
        printed(details(still)).split()
    )


def test_the_share_of_exact_strains_and_of_vibration_is_told():
    result = analyse(load(DEMOS / "slider_crank.toml").changed(effects="auto", tolerance=1e-3))
    said = " ".join(printed(details(result)).split())
    assert re.search(r"large-rotations \([45]\.\d %\).*; the share is what linear strains would leave out", said)
    peak = float(np.abs(between_positions(result).data["stress"]).max())
    change = share(abs(float(np.abs(result.data["stress_quasi_static"]).max()) / peak - 1))
    assert f"Vibration changes the peak stress by {change}, as solved" in said
    assert f"(as solved {change} of the peak stress)" in " ".join(str(summary(result)).split())
