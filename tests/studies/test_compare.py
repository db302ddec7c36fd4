"""Comparisons: known shifts and differences come out, and what cannot be compared is said."""

import numpy as np
import pytest
from typer.testing import CliRunner

from fenics_mech.cli import app
from fenics_mech.errors import MechanismError, ResultError
from fenics_mech.recovery import Result
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.studies.compare import (
    MID_SPAN,
    Quantity,
    compare,
    curves_of_measurement,
    curves_of_result,
    with_vibration,
)
from fenics_mech.views.comparison import differing_speeds
from fenics_mech.views.reading import Reading
from tests.common import response_of

PLACE = Quantity("strain", "coupler", 0.3, "-")
NAMED = ("member", "link", "point", "pair")  # coordinates of a result, made of names of its scene


@pytest.fixture(scope="module")
def result():
    return response_of(seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 180}))


@pytest.fixture(scope="module")
def source(result):
    return curves_of_result(result, "computed", MID_SPAN)


@pytest.fixture(scope="module")
def vibrating(result):
    scene = result.scene.changed(analysis__method="periodic", damping={"ratio": 0.02})
    return curves_of_result(response_of(scene), "computed")


def test_a_result_does_not_differ_from_itself(source):
    data = compare([source, source])
    assert list(data["quantity"].to_numpy())[:4] == [
        "strain crank",
        "strain coupler",
        "strain follower",
        "deflection crank",
    ]
    for name in ("difference", "rms", "shift", "largest_difference"):
        assert np.abs(data[name]).max() == pytest.approx(0, abs=1e-15)


def late(result, angle, factor=1.0):
    """Strains at few angles that come later by an angle than those of the coupler at 0.3, lower side."""
    theta, strain = result.data["theta"].to_numpy(), result.strain_at("coupler", 0.3, "-")
    measured = np.radians(np.arange(4, 360, 12.0))
    return measured, factor * np.interp(measured - angle, theta, strain, period=2 * np.pi)


@pytest.mark.parametrize("degrees", [-40.0, 7.3])
def test_shift_of_a_measurement_comes_out(result, source, degrees):
    gauge = curves_of_measurement(*late(result, np.radians(degrees)), PLACE, "gauge")
    data = compare([source, gauge]).sel(other="gauge", quantity="strain coupler s=0.3 -")
    assert np.degrees(float(data["shift"])) == pytest.approx(degrees, abs=0.05)
    assert float(data["rms_shifted"]) < 0.01 * float(data["rms"])


def test_what_is_later_under_a_drive_that_turns_backwards_has_a_positive_shift(result):
    back = response_of(result.scene.changed(drive__speed=-32.3)).data
    late = back.assign(strain=back["strain"].roll(theta=10))
    data = compare([curves_of_result(Result(one), "computed") for one in (back, late)])
    found = data.sel(quantity=data["quantity"].str.startswith("strain"))
    assert np.degrees(found["shift"].to_numpy()) == pytest.approx(20.0, abs=1e-3)
    assert float(found["rms_shifted"].max()) < 1e-4 * float(found["rms"].max())


def test_scale_of_a_measurement_is_a_difference_without_a_shift(result, source):
    gauge = curves_of_measurement(*late(result, 0.0, 1.2), PLACE, "gauge")
    data = compare([source, gauge]).sel(other="gauge", quantity=PLACE.label)
    curve = gauge.curve(PLACE)[1] / 1.2
    assert float(data["rms"]) == pytest.approx(0.2 * np.sqrt(np.mean(curve**2)), rel=1e-3)
    assert float(data["difference"]) == pytest.approx(0.2 * curve[np.abs(curve).argmax()], rel=1e-3)
    assert np.degrees(float(data["shift"])) == pytest.approx(0.0, abs=0.2)


def test_ripples_of_a_measurement_have_a_frequency(result, source, vibrating):
    """Nine in a cycle of 0.1945 s are 46.3 Hz, on the quasi-static curve and with some noise."""
    theta, strain = result.data["theta"].to_numpy(), result.strain_at("coupler", 0.3, "-")
    noise = np.random.default_rng(3).normal(size=len(theta))
    size = np.ptp(strain)
    wave = strain + 0.3 * size * np.cos(9 * theta) + 0.003 * size * noise
    gauge = curves_of_measurement(theta, wave, PLACE, "gauge")
    assert with_vibration(gauge, vibrating).vibration["coupler"] == pytest.approx(9 * 32.3 / (2 * np.pi))
    assert not with_vibration(gauge, source).vibration  # without natural frequencies nothing is known to vibrate
    other = curves_of_measurement(theta, wave, PLACE, "other")
    assert not with_vibration(other, other).vibration


def test_multiples_of_the_drive_are_no_vibration(result, vibrating):
    """The lowest mode of the seed has 42 Hz at least, of which 3 times the drive, 15.4 Hz, are far away."""
    theta, strain = result.data["theta"].to_numpy(), result.strain_at("coupler", 0.3, "-")
    for times, rates in ((3, {}), (9, {"coupler": pytest.approx(9 * 32.3 / (2 * np.pi))})):
        wave = strain + 0.3 * np.ptp(strain) * np.cos(times * theta)
        gauge = curves_of_measurement(theta, wave, PLACE, "gauge")
        assert with_vibration(gauge, vibrating).vibration == rates


def test_members_are_compared_where_a_run_tells_their_peaks(result):
    reading = Reading(result)
    known = curves_of_result(result, "computed").known
    for i, member in enumerate(reading.members):
        peak, bent = reading.peaks[i], reading.peak(reading.bent, i)
        assert Quantity("strain", member, reading.s[peak.j], "+-"[peak.f]) in known
        assert Quantity("deflection", member, reading.s[bent.j]) in known


def test_largest_difference_is_found_anywhere_along_a_member(result, source):
    """It is put at 40 % of the length on the lower side, where neither the peak nor mid-span is."""
    changed = result.data.copy(deep=True)
    place = {
        "member": "coupler",
        "s": changed["s"].to_numpy()[8],
        "fibre": "-",
        "theta": changed["theta"].to_numpy()[30],
    }
    changed["strain"].loc[place] -= 1e-4
    data = compare([source, curves_of_result(Result(changed), "changed", MID_SPAN)]).sel(other="changed")
    found = data.sel(quantity="strain coupler")
    assert float(found["difference"]) == 0
    assert float(found["largest_difference"]) == pytest.approx(-1e-4)
    assert (float(found["largest_s"]), found["largest_fibre"].item()) == (place["s"], "-")
    assert float(found["largest_theta"]) == place["theta"]
    assert float(data.sel(quantity="strain crank")["largest_difference"]) == 0


def test_results_with_other_stations_are_compared_at_the_fewer(result, source):
    """The stations of all peaks are among them: curves are given at the drive angles of the peaks too."""
    fewer = Result(result.data.isel(s=[0, 4, 8, 11, 12, 16, 20]))
    data = compare([source, curves_of_result(fewer, "fewer")]).sel(quantity=["strain crank", "deflection coupler"])
    assert np.abs(data["largest_difference"]).max() < 1e-15


def test_few_stations_are_no_difference_of_the_motion(result):
    """A spline through 6 of the 21 stations is off by less than 1 %, straight lines by 2.9 %."""
    every = curves_of_result(result, "all")
    data = compare([every, curves_of_result(Result(result.data.isel(s=slice(None, None, 4))), "fewer")])
    of_members = data.isel(quantity=slice(0, 6))
    assert float((np.abs(of_members["difference"]) / np.abs(of_members["peak_reference"])).max()) < 0.01


def test_few_positions_are_no_difference_of_lengths():
    """A deflection turns at nearly zero length within a degree: of 360 positions alone, it is off by 1.4 %."""
    scene = seed_four_bar(analysis={"sub_intervals": 360}, damping={"ratio": 0.02})
    results = [response_of(scene.changed(analysis__sub_intervals=count)) for count in (360, 720)]
    data = compare([curves_of_result(one, "computed") for one in results]).isel(quantity=slice(3, 10))
    assert float((np.abs(data["difference"]) / np.abs(data["peak_reference"])).max()) < 0.004


def test_what_has_no_cycle_is_refused():
    static = response_of(seed_four_bar(analysis={"method": "static"}))
    with pytest.raises(ResultError, match="static or not periodic"):
        curves_of_result(static, "held")


@pytest.fixture(scope="module")
def folder(tmp_path_factory, result):
    place = tmp_path_factory.mktemp("compare")
    result.save(place / "a.nc")
    faster = result.data.copy(deep=True)
    faster["strain"] = 1.5 * faster["strain"]
    Result(faster).save(place / "b.nc")
    theta, strain = late(result, 0.1)
    lines = "".join(f"{np.degrees(a):.6f},{e:.6e}\n" for a, e in zip(theta, strain))
    (place / "gauge.csv").write_text(f"angle,strain\n{lines}")
    return place


def run(*words):
    done = CliRunner().invoke(app, ["compare", *map(str, words)], env={"COLUMNS": "80"})
    if isinstance(done.exception, MechanismError):
        return f"error: {done.exception}"
    assert done.exit_code == 0, done.output
    return done.output


def test_command_writes_table_and_plots(folder):
    out = folder / "out"
    gauge = ("--member", "coupler", "--s", "0.3", "--fibre", "-")
    text = run(folder / "a.nc", folder / "b.nc", folder / "gauge.csv", *gauge, "-o", out)
    assert "b against a" in text
    assert "measured (gauge) against a" in text
    assert max(map(len, text.splitlines()[:-1])) <= 80
    assert {path.name for path in out.iterdir()} >= {"compare.csv", "compare_strain.png", "compare_joint_force.png"}
    lines = (out / "compare.csv").read_text().splitlines()
    row = next(line for line in lines if line.startswith("b,strain crank s=0"))
    names = dict(zip(lines[0].split(","), row.split(",")))
    assert float(names["peak"]) == pytest.approx(1.5 * float(names["peak_reference"]))
    forces = next(line for line in lines if line.startswith("b,joint force O"))
    assert float(dict(zip(lines[0].split(","), forces.split(",")))["rms"]) == 0


def test_runs_that_differ_in_speed_are_told(result):
    faster = result.scene.changed({"drive.speed": "400 rpm"})
    assert differing_speeds({"a": result.scene, "b": result.scene}, result.scene) == ""
    told = differing_speeds({"a": result.scene, "b": faster}, result.scene.changed(units=("rpm",)))
    assert told.startswith("The runs differ in speed, and are compared at equal drive angles. a: joint O at 308.4 rpm")
    assert "; b: joint O at 400 rpm" in told


def test_comparisons_are_told_in_the_units_of_the_first_scene(folder, result):
    result.told_in(["%", "in", "lbf"]).save(folder / "inches.nc")
    text = run(folder / "inches.nc", folder / "b.nc", "-o", folder / "units")
    lines = text.splitlines()
    row = lines[lines.index(next(line for line in lines if "joint force (lbf)" in line)) + 1]
    force = np.linalg.norm(result.data["joint_force"].sel(joint="O").transpose("theta", "component"), axis=-1)
    assert float(row.split()[1]) == pytest.approx(force.max() / 4.4482216, rel=1e-3)
    assert "strain (%)" in text
    assert "deflection (in)" in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["gauge.csv", "a.nc"], "the reference, which stands first"),
        (["a.nc"], "nothing to compare with"),
        (["a.nc", "gauge.csv"], "add --member"),
        (["a.nc", "gauge.csv", "--member", "rod"], "no member 'rod'; it has crank, coupler, follower"),
        (["a.nc", "b.txt"], "compared are results"),
        (["a.nc", "b.nc", "--fibre", "x"], "--fibre is"),
        (["a.nc", "b.nc", "--at", "2"], "--at is peak, mid-span or a share of the length from 0 to 1, found '2'"),
    ],
)
def test_command_says_what_it_cannot_compare(folder, words, message):
    files = [folder / word if "." in word else word for word in words]
    assert message in run(*files, "-o", folder / "none")
    assert not (folder / "none").exists()


def test_scene_says_where_a_measurement_was_taken(folder, result):
    scene = result.scene.changed(
        measurements=({"file": str(folder / "gauge.csv"), "member": "coupler", "s": 0.3, "fibre": "-"},)
    )
    Result(result.data.assign_attrs(scene=scene.model_dump_json())).save(folder / "with.nc")
    assert "coupler 83.8 mm from A, \N{MINUS SIGN}" in run(folder / "with.nc", "-o", folder / "with")


def test_measurement_at_a_member_that_the_reference_lacks_is_left_out(folder, result):
    stated = ({"file": str(folder / "gauge.csv"), "member": "coupler", "s": 0.3, "fibre": "-"},)
    scene = result.scene.changed(measurements=stated).model_dump_json().replace("coupler", "arm")
    names = {kind: [str(name).replace("coupler", "arm") for name in result.data[kind].values] for kind in NAMED}
    Result(result.data.assign_coords(names).assign_attrs(scene=scene)).save(folder / "arm.nc")
    text = run(folder / "a.nc", folder / "arm.nc", "-o", folder / "left")
    assert "gauge.csv: left out, the reference has no member 'arm'; it has crank, coupler, follower" in text
    assert "measured" not in text
    assert "strain coupler" not in (folder / "left" / "compare.csv").read_text()
