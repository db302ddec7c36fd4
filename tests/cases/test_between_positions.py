"""Peaks between positions: told as an error, refused where it is large, against an own Newton-Euler four-bar."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.analysis import analyse
from fenics_mech.recovery.peaks import doubts, peak_of
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views.judgements import judgements, verdict
from fenics_mech.views.key_figures import key_figures
from fenics_mech.views.reading import reading_of
from fenics_mech.views.summary import summary
from tests.common import DEMOS, analysed, too_coarse

SCENES = Path(__file__).parent / "scenes"
CRANK, COUPLER, ROCKER, SPEED, DENSITY = 0.1, 0.25, 0.2, 10.0, 2714 * 0.02 * 0.005  # m, rad/s, kg/m


def newton_euler(ground, angles=60_000):
    """Give the largest force in each of the joints A, B, C and O of uniform rods (N), from closed-form positions.

    The rods are centred at their middles; equilibrium of coupler and rocker gives B and A, and so C and O.
    """
    theta = 2 * np.pi / angles * np.arange(angles)
    a = CRANK * np.exp(1j * theta)
    across = ground - a  # from A to C; B lies to the left of it, and is the meeting point of two circles
    along = (COUPLER**2 - ROCKER**2 + np.abs(across) ** 2) / (2 * np.abs(across))
    b = a + across / np.abs(across) * (along + 1j * np.sqrt(COUPLER**2 - along**2))
    ab, cb = b - a, b - ground
    va, aa = 1j * SPEED * a, -(SPEED**2) * a

    def turning(force):  # rates of both rods by  va + i w1 ab = i w2 cb, or its derivative
        return np.linalg.solve(
            np.stack([np.stack([-ab.imag, cb.imag], -1), np.stack([ab.real, -cb.real], -1)], -2),
            np.stack([-force.real, -force.imag], -1)[..., None],
        )[..., 0]

    w1, w2 = turning(va).T
    alpha1, alpha2 = turning(aa - w1**2 * ab + w2**2 * cb).T
    at_coupler = aa + (1j * alpha1 - w1**2) * ab / 2
    at_rocker = (1j * alpha2 - w2**2) * cb / 2
    m0, m1, m2 = DENSITY * CRANK, DENSITY * COUPLER, DENSITY * ROCKER
    # moments about A of the coupler, under the force f on it at B, and about C of the rocker, under -f
    cross = lambda r, f: r.real * f.imag - r.imag * f.real  # noqa: E731
    one = m1 * COUPLER**2 / 12 * alpha1 + cross(ab / 2, m1 * at_coupler)
    two = m2 * ROCKER**2 / 3 * alpha2
    rows = np.stack([np.stack([-ab.imag, ab.real], -1), np.stack([cb.imag, -cb.real], -1)], -2)
    f = np.linalg.solve(rows, np.stack([one, two], -1)[..., None])[..., 0]
    f = f[:, 0] + 1j * f[:, 1]
    on_a = m1 * at_coupler - f
    on_c = m2 * at_rocker + f
    on_o = m0 * aa / 2 + on_a
    return {name: np.abs(part).max() for name, part in zip("ABCO", (on_a, f, on_c, on_o))}


def four_bar(count, neutral_by=1e-4, **changes):
    scene = load(SCENES / "near_neutral_four_bar.toml")
    ground = {"points": {"O": (0.0, 0.0), "C": (0.35 - neutral_by, 0.0)}}
    return scene.changed(ground=ground, analysis__sub_intervals=count, **changes)


def rigid_four_bar(count, neutral_by=1e-4, **changes):
    """Give the same of rods that do not bend."""
    scene, links = four_bar(count, neutral_by), {}
    for name, ends, length in (("crank", "OA", CRANK), ("coupler", "AB", COUPLER), ("rocker", "CB", ROCKER)):
        body = {"mass": DENSITY * length, "inertia": DENSITY * length**3 / 12, "centre": (length / 2, 0.0)}
        angle = {} if scene.links[name].angle is None else {"angle": scene.links[name].angle}
        links[name] = {"rigid": body, "points": {ends[0]: (0.0, 0.0), ends[1]: (length, 0.0)}, **angle}
    return scene.changed(links=links, **changes)


def shown_and_true(result, many):
    """Give for joint forces, torque and accelerations the peaks shown, the true ones, and the errors told.

    Joint forces and the torque are read from curves through the positions, accelerations at the positions themselves.
    """
    read = {name: np.abs(peak_of(result, name)[2]) for name in ("joint_force", "input_torque")}
    true = {name: np.abs(peak_of(many, name)[2]) for name in read}
    for data, peaks in ((result.data, read), (many.data, true)):
        of_points = data["point_acceleration"].transpose("theta", "point", "component").to_numpy()
        peaks["point_acceleration"] = np.linalg.norm(of_points, axis=-1).max(axis=0)
    of_error = {"input_torque": "drive_effort"}
    told = {name: result.data[f"{of_error.get(name, name)}_error"].sel(source="positions").to_numpy() for name in read}
    return [(name, read[name], true[name], told[name]) for name in read]


def largest(result):
    return dict(zip(result.data["joint"].to_numpy().tolist(), np.abs(peak_of(result, "joint_force")[2])))


@pytest.mark.parametrize("neutral_by", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("count", [12, 25, 37, 60, 101, 121, 201, 360])
def test_a_spike_between_positions_is_right_or_told(count, neutral_by):
    """At 60,000 angles the reference has its peaks to 1e-6: the spike is 0.03 rad wide."""
    right = newton_euler(0.35 - neutral_by)
    found = largest(analysed(four_bar(count, neutral_by)))
    if said := too_coarse(four_bar(count, neutral_by)):
        enough = int(said.split("Take at least ")[1].split(maxsplit=1)[0])
        found = largest(analyse(four_bar(enough, neutral_by)))  # the advice is true
        if " reaches " not in said or " at drive angle " not in said:
            pytest.fail(said)
    for joint, force in right.items():
        assert abs(found[joint] / max(right.values()) - force / max(right.values())) < 0.05, joint


def test_the_reference_is_that_of_the_report():
    """Own Newton-Euler of the report, 60,000 angles: 176.5 N."""
    assert max(newton_euler(0.3499).values()) == pytest.approx(176.5, abs=0.05)


@pytest.mark.parametrize("count", [12, 25, 37, 60, 121, 360])
def test_told_is_true_and_falls_as_the_answer_improves(count):
    """The motion without vibration is known between positions too: what is told is the error itself."""
    result = analyse(four_bar(count, analysis__allow_coarse=True))
    right = newton_euler(0.3499)
    told = result.data["joint_force_error"].sel(source="positions")
    for joint, force in largest(result).items():
        missed = abs(force - right[joint])
        assert float(told.sel(joint=joint)) == pytest.approx(missed, rel=0.02, abs=1e-3 * max(right.values()))
    assert (doubts(result)["joint_force"] < 1e-3) == (max(abs(f - right[j]) for j, f in largest(result).items()) < 0.05)


@pytest.fixture(scope="module")
def rigid_many():
    """20,000 positions show the spike of 0.03 rad to 1e-7 of it."""
    return analyse(rigid_four_bar(20_000, analysis__error_estimates=False))


@pytest.mark.parametrize("count", [12, 25, 37, 60, 121, 360])
def test_rigid_links_tell_of_forces_torques_and_accelerations_between_positions(count, rigid_many):
    """They are known at any angle: what is told is the error itself, as 3600 angles and eighths of these show it."""
    result = analyse(rigid_four_bar(count, analysis__allow_coarse=True))
    for name, shown, true, told in shown_and_true(result, rigid_many):
        assert told == pytest.approx(np.abs(true - shown), rel=2e-3, abs=3e-4 * true.max()), name


def printed(result):
    """Give torque and joint forces as summary, key figures and report print them."""
    row = next(line for line in str(summary(result)).splitlines() if "input torque" in line)
    figures, reading = key_figures(result), reading_of(result)
    assert abs(figures["input_torque"]["value"]) == pytest.approx(np.abs(reading.effort).max())
    forces = {name: joint["value"] for name, joint in figures["joints"].items()}
    assert list(forces.values()) == pytest.approx(reading.force.max(axis=0))
    return abs(float(row.split()[2])), forces


@pytest.mark.parametrize("neutral_by", [5e-2, 1e-2])
@pytest.mark.parametrize("count", [12, 24, 61])
def test_printed_numbers_of_rigid_links_are_as_wrong_as_is_told(count, neutral_by):
    """They were those at the positions, 15 to 0.7 % below the peak, and told were the errors of curves: 0.1 to 1.4 %.

    2e-4 is the rounding of the printed torque to four digits.
    """
    many = analyse(rigid_four_bar(3600, neutral_by, analysis__error_estimates=False)).data
    result = analyse(rigid_four_bar(count, neutral_by, analysis__allow_coarse=True))
    (torque, forces), true = printed(result), float(np.abs(many["input_torque"]).max())
    told = float(result.data["drive_effort_error"].sel(source="positions").max())
    assert abs(torque - true) == pytest.approx(told, rel=0.02, abs=2e-4 * true)
    of_joints = np.linalg.norm(many["joint_force"].transpose("theta", "joint", "component"), axis=-1).max(axis=0)
    errors = np.abs(of_joints - list(forces.values()))
    told = result.data["joint_force_error"].sel(source="positions").to_numpy()
    assert errors == pytest.approx(told, rel=0.02, abs=2e-4 * of_joints.max())


def test_the_verdict_of_a_torque_that_few_positions_miss_is_not_that_it_can_be_used():
    """12 positions miss 15 % of the torque; joint forces are off by less than the 5 % that are refused."""
    few = analyse(rigid_four_bar(12, 1e-2))
    assert 0.14 < few.data.attrs["drive_effort_error_estimate"] < 0.16
    said = "Use the numbers with care: links are rigid, positions too few."
    assert verdict(judgements(few)) == ("warn", said)
    text = " ".join(str(summary(few)).split())
    assert said in text
    assert "efforts are off by at most 15 % of the largest" in text
    assert key_figures(few)["verdict"] == {"level": "warn", "sentence": said}
    enough = analyse(rigid_four_bar(60, 1e-2))
    assert verdict(judgements(enough))[0] == "note"
    assert "with care" not in str(summary(enough))


def test_rigid_links_whose_errors_are_not_estimated_are_not_called_accurate():
    result = analyse(rigid_four_bar(12, 1e-2, analysis__error_estimates=False))
    level, said = verdict(judgements(result))
    assert level == "warn"
    assert said == "Use the numbers with care: links are rigid, error not estimated."
    assert "as analysis.error_estimates = false" in " ".join(str(summary(result)).split())


def test_what_rigid_links_tell_falls_as_positions_rise():
    """12 and 60 positions hit the spike at 180 deg by luck; odd numbers come within half a step of it."""
    told = []
    for count in (25, 121, 361, 1441):
        data = analyse(rigid_four_bar(count, analysis__allow_coarse=True)).data
        names = "joint_force", "drive_effort", "point_acceleration"
        told.append([float(data[f"{name}_relative_error"].sel(source="positions")) for name in names])
    assert (np.diff(told, axis=0) < 0).all()
    assert max(told[-1]) < 0.02 < 0.8 < min(told[0])


@pytest.mark.parametrize("count", [25, 37, 121])
def test_positions_of_rigid_links_are_told_as_those_of_bent_ones_are(count, rigid_many):
    enough = advised(rigid_four_bar(count))
    for name, shown, true, _ in shown_and_true(analyse(rigid_four_bar(enough)), rigid_many):
        if name == "joint_force":
            assert shown == pytest.approx(true, abs=0.05 * true.max())
    said = too_coarse(rigid_four_bar(count))
    assert re.search(r"force in joint '\w' reaches 17[56]\.\d N at drive angle 180 deg", said)


@pytest.mark.parametrize("count", [25, 37, 121])
def test_accelerations_of_bent_links_have_peaks_between_positions_too(count, rigid_many):
    """Points on the axes of unbent links are those of rigid ones; 2 %: the spike is looked at less closely."""
    result = analyse(four_bar(count, analysis__allow_coarse=True))
    _, shown, true, told = shown_and_true(result, rigid_many)[-1]
    assert told == pytest.approx(np.abs(true - shown), rel=0.02, abs=1e-3 * true.max())


def vibrating_points(count):
    """Give the largest accelerations of points that vibrate, at the positions, and the errors told of them."""
    changes = {"analysis__stability": False, "analysis__allow_coarse": True, "analysis__sub_intervals": count}
    data = analyse(load(DEMOS / "four_bar.toml").changed(**changes)).data
    of_points = data["point_acceleration_bent"].transpose("theta", "point", "component").to_numpy()
    told = data["point_acceleration_bent_error"].sel(source="positions").to_numpy()
    return np.linalg.norm(of_points, axis=-1).max(axis=0), told


@pytest.mark.long
@pytest.mark.slow
def test_accelerations_of_links_that_vibrate_are_told_of():
    """Against 720 positions: what is told of few positions is half of the error, at the least.

    1 % of the largest may be by the time steps, and 6 % with fewer than 80 of them: of accelerations nothing tells it.
    """
    true = vibrating_points(720)[0]
    for count in (40, 50, 60, 80, 120, 240):
        shown, told = vibrating_points(count)
        assert (np.abs(true - shown) <= 2 * told + (0.06 if count < 80 else 0.01) * true.max()).all(), count
        assert told[0] == 0  # a pin on the ground is at rest
    assert told.max() < 0.02 * true.max()


@pytest.mark.parametrize("count", [12, 25, 37, 60, 121])
def test_a_narrow_pulse_between_positions_is_told(count):
    """A force at the middle of the rocker, 3 deg wide: against 2880 positions, of which 24 see it."""
    pulse = {"kind": "pulse", "start": 1.0, "end": 1.05, "ramp": 0.02}
    loads = {"press": {"at": "rocker@0.5", "force": (0.0, -20.0), "factor": pulse}}
    many = analyse(four_bar(2880, 1e-2, loads=loads, analysis__error_estimates=False))
    few = analyse(four_bar(count, 1e-2, loads=loads, analysis__allow_coarse=True))
    true = np.abs(np.abs(peak_of(few, "strain")[2]) - np.abs(peak_of(many, "strain")[2]))
    told = few.data["strain_error"].sel(source="positions").to_numpy()
    assert told == pytest.approx(true, rel=0.05, abs=2e-3 * np.abs(many.data["strain"]).max().item())


def advised(scene):
    """Give the sub-intervals that the answer of a scene advises, which states too few of them."""
    return int(too_coarse(scene).split("Take at least ")[1].split(maxsplit=1)[0])


def jansen(count):
    changes = {"analysis__method": "quasi-static", "effects": (), "analysis__sub_intervals": count}
    return load(DEMOS / "jansen.toml").changed(**changes)


def vibrating(count):
    periodic = {"analysis__method": "periodic", "analysis__solver": "collocation", "damping__ratio": 0.02}
    return four_bar(count, 1e-3, drive__speed=3.0, **periodic)


@pytest.mark.long
@pytest.mark.parametrize(
    ("machine", "counts"),
    [
        (four_bar, (12, 25, 60, 101)),  # of which 12 and 60 show all but one peak by luck
        (vibrating, (12, 25, 60)),
        (jansen, (12, 25)),
    ],
)
@pytest.mark.xfail(reason="three numbers of sub-intervals are advised for a vibration")
def test_advice_is_one_number_and_suffices_once_followed(machine, counts):
    """It rose and fell with the positions that were tried: 315, 656, 305."""
    numbers = {advised(machine(count)) for count in counts}
    assert len(numbers) == 1
    (enough,) = numbers
    for more in (enough, enough + 1, enough + 3, math.ceil(1.1 * enough)):
        assert not too_coarse(machine(more))  # it says "at least"


@pytest.mark.xfail(reason="by poses the positions are named, and not the steps", strict=False)
@pytest.mark.slow
def test_steps_that_are_too_long_name_the_positions_that_peaks_take_too():
    """The steps of this strip are too long, and its peaks take more positions than its steps."""
    scene = seed_four_bar(effects=("coupling",), damping={"material": 5e-3}, mesh={"elements": 2})
    few = scene.changed(analysis__sub_intervals=24, analysis__stability=False, analysis__solver="collocation")
    assert "sub-intervals are too long" in too_coarse(few)
    told = advised(few)
    missed = analyse(few.changed(analysis__allow_coarse=True)).data["strain_error"].sel(source="positions")
    assert float(missed.max()) > 0
    shown = analyse(few.changed(analysis__sub_intervals=told, analysis__allow_coarse=True))
    assert max(doubts(shown).values()) < 0.05


@pytest.mark.long
@pytest.mark.slow
def test_a_motor_has_peaks_by_its_own_rate():
    """On a shaft the crank's rate varies: 80 positions against 240, which see three times as many harmonics."""
    shaft = {"stiffness": 60.0, "damping": 0.05, "inertia": 2e-3}
    scene = load(DEMOS / "four_bar.toml").changed(effects=("coupling",), analysis__stability=False, drive__motor=shaft)
    few, many = (analyse(scene.changed(analysis__sub_intervals=count)) for count in (80, 240))
    told = few.data["joint_force_error"].sel(source=["positions", "time"]).sum("source").to_numpy()
    right = np.abs(peak_of(many, "joint_force")[2])
    assert (np.abs(np.abs(peak_of(few, "joint_force")[2]) - right) <= told + 1e-3 * right.max()).all()
    assert doubts(few)["joint_force"] < 0.05  # by a constant rate of the crank it would be 0.8, and refused
