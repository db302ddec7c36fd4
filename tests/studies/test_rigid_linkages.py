"""What is asked of a linkage of which no link bends is answered, or refused by one message that says why."""

import re

import numpy as np
import pytest

from fenics_mech import StressLife, analyse, cli
from fenics_mech.recovery import Result
from fenics_mech.scene.factories import seed_four_bar

FOUR_BAR = """
name = "rigid four-bar"
[ground]
points = { O = [0, 0], C = [0.254, 0] }
[links.crank]
points = { O = [0, 0], A = [0.108, 0] }
rigid = { mass = 0.3, inertia = 1e-4 }
[links.coupler]
points = { A = [0, 0], B = [0.2794, 0] }
angle = "70 deg"
rigid = { mass = 0.3, inertia = 1e-3, centre = [0.1, 0] }
[links.follower]
points = { C = [0, 0], B = [0.27, 0] }
angle = "100 deg"
rigid = { mass = 0.3, inertia = 1e-3, centre = [0.1, 0] }
[joints]
O.connect = ["ground.O", "crank.O"]
A.connect = ["crank.A", "coupler.A"]
B.connect = ["coupler.B", "follower.B"]
C.connect = ["ground.C", "follower.C"]
[drive]
joint = "O"
speed = 30
[points]
P = { at = "coupler.A", offset = [0.14, 0.06] }
[analysis]
method = "periodic"
sub_intervals = 36
"""
POUND = 4.4482216152605


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    """Run `fenics-mech` in a folder with the scene, that in time, and their results."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "led.toml").write_text(FOUR_BAR)
    (tmp_path / "time.toml").write_text(FOUR_BAR.replace('"periodic"', '"transient"\ncycles = 1'))

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["fenics-mech", *arguments])
        try:
            cli.main()
            code = 0
        except SystemExit as end:
            code = end.code
        printed = capsys.readouterr()
        return code or 0, printed.out, printed.err

    for name in ("led", "time"):
        assert run("run", f"{name}.toml", "-o", name, "--no-plots", "--quiet")[0] == 0
    return run


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("refine led.toml", "no link has a member, and a refinement"),
        ("compare led.toml", "no link has a member: the theories differ"),
        ("compare time/result.nc led/result.nc", "there is no cycle in it to compare"),
        ("export led.toml model.py", "no link has a member, and other programs"),
        ("export led/result.nc motion.pvd", "no link of this result bends"),
        ("plot led/result.nc --only strain", "the result has nothing for strain"),
        ("fatigue led.toml", "no material states `fatigue`"),
        ("modes led.toml", "no link has a member"),
        ("sweep led.toml --over drive.speed=10:20:2", "no link has a member"),
    ],
)
def test_what_needs_links_that_bend_is_refused(call, words, said):
    code, _, error = call(*words.split())
    assert code == 1
    assert said in re.sub(r"\s+", " ", error)


@pytest.mark.parametrize("words", ["compare bad.nc bad.nc", "fatigue bad.nc", "export bad.nc motion.pvd"])
def test_a_result_that_lacks_what_is_read_is_one_message(call, tmp_path, words):
    """Of a bent linkage; an older version may have written it, or a stranger."""
    curve = StressLife(range="40 MPa", slope=5)
    scene = seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24}, effects=())
    result = analyse(scene.changed({f"materials.{name}.fatigue": curve for name in scene.materials}))
    Result(result.data.drop_vars(["stress", "deflection"])).save(tmp_path / "bad.nc")
    code, _, error = call(*words.split())
    assert code == 1
    assert "the result lacks what is shown" in re.sub(r"\s+", " ", error)
    assert not (tmp_path / "motion").exists()


def test_joint_forces_of_two_runs_are_compared(call, tmp_path):
    (tmp_path / "heavier.toml").write_text(FOUR_BAR.replace("mass = 0.3", "mass = 0.6").replace("1e-", "2e-"))
    code, _, error = call("compare", "led/result.nc", "heavier.toml", "-o", "out")
    assert code == 0, error
    table = [line.split(",") for line in (tmp_path / "out" / "compare.csv").read_text().splitlines()]
    peaks = {row[table[0].index("quantity")]: row for row in table[1:]}
    one, two = (float(peaks["joint force O"][table[0].index(name)]) for name in ("peak_reference", "peak"))
    assert two == pytest.approx(2 * one)


def test_points_of_rigid_links_are_followed(call, tmp_path):
    """P turns with the coupler about A: its distance from A stays, and its rate is that of its path."""
    data = Result.load(tmp_path / "led" / "result.nc").data
    paths = {name: data["point_position"].sel(point=name).to_numpy() for name in ("P", "coupler.A")}
    assert np.linalg.norm(paths["P"] - paths["coupler.A"], axis=1) == pytest.approx(np.hypot(0.14, 0.06))
    order = 1j * np.fft.fftfreq(36, 1 / 36)[:, None]
    rate = 30 * np.fft.ifft(order * np.fft.fft(paths["P"], axis=0), axis=0).real
    velocity = data["point_velocity"].sel(point="P").to_numpy()
    assert np.abs(velocity - rate).max() < 1e-3 * np.abs(velocity).max()


def test_units_that_are_asked_for_are_those_of_rigid_links_too(call):
    forces = []
    for more in ((), ("--units", "lbf, rpm, lbf in")):
        text = call("run", "led.toml", "-o", "out", "--no-plots", *more)[1]
        forces.append(next(line.split() for line in text.splitlines() if line.split()[:1] == ["B"]))
    assert forces[1][2] == "lbf"
    assert float(forces[1][1]) == pytest.approx(float(forces[0][1]) / POUND, rel=1e-3)
    assert "at 286.5 rpm;" in text


def test_the_frame_takes_what_the_supports_give(call, tmp_path):
    """Without weight and loads: minus the forces of the ground's joints, and minus their moment less the torque."""
    data = Result.load(tmp_path / "led" / "result.nc").data
    o, c = (data["joint_force"].sel(joint=name) for name in "OC")
    total = -(o + c).transpose("theta", "component").to_numpy()
    shaking = data["shaking_force"].transpose("theta", "component").to_numpy()
    assert shaking == pytest.approx(total, abs=1e-9 * np.abs(total).max())
    moment = -0.254 * c.sel(component="y").to_numpy() - data["input_torque"].to_numpy()
    assert data["shaking_moment"].to_numpy() == pytest.approx(moment, abs=1e-9 * np.abs(moment).max())


def test_weight_and_the_rotor_of_a_motor_act_on_the_frame(call, tmp_path):
    """A disc about its centre is held by minus its weight; a free one with a rotor takes the motor's torque."""
    disc = """
    name = "disc"
    gravity = [0, -10]
    [ground]
    points = { O = [0.5, 0] }
    [links.disc]
    points = { O = [0, 0], A = [0.1, 0] }
    rigid = { mass = 2, inertia = 0.02 }
    [joints]
    O.connect = ["ground.O", "disc.O"]
    [freedoms.O]
    effort = 0.6
    inertia = 0.01
    [analysis]
    method = "transient"
    duration = 0.1
    sub_intervals = 20
    """
    (tmp_path / "disc.toml").write_text(disc)
    assert call("run", "disc.toml", "-o", "disc", "--no-plots", "--quiet") == (0, "", "")
    data = Result.load(tmp_path / "disc" / "result.nc").data
    assert data["link_alpha"].sel(link="disc").to_numpy() == pytest.approx(0.6 / 0.03)
    assert data["shaking_force"].sel(component="y").to_numpy() == pytest.approx(-20)
    assert data["shaking_moment"].to_numpy() == pytest.approx(-20 * 0.5 - 0.6)  # the weight's, and the motor's


def test_rigid_linkages_have_a_report(call, tmp_path):
    for name in ("led", "time"):
        assert call("report", f"{name}/result.nc", "--units", "lbf", "-o", f"{name}.html")[0] == 0
        page = (tmp_path / f"{name}.html").read_text()
        force = (Result.load(tmp_path / name / "result.nc").data["joint_force"] ** 2).sum("component").max() ** 0.5
        value = re.search(r"Largest joint force ([\d.]+) lbf", page)
        assert float(value[1]) == pytest.approx(float(force) / POUND, rel=5e-3)
        assert "on the frame" in page
        assert "links are rigid" in page


def test_a_motion_in_time_has_its_peaks_at_times(call, tmp_path):
    text = call("run", "time.toml", "-o", "out", "--no-plots")[1]
    row = next(line.split() for line in text.splitlines() if line.split()[:1] == ["C"])
    force = (Result.load(tmp_path / "time" / "result.nc").data["joint_force"].sel(joint="C") ** 2).sum("component")
    assert "at time" in text
    assert float(row[3]) == pytest.approx(float(force["time"][int(force.argmax("theta"))]), rel=1e-3)
    assert row[4] == "s"
