"""Least squares against closed forms, their intervals against repeated measurements, and identified scenes."""

import warnings
from functools import partial

import numpy as np
import pytest
from scipy import optimize

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.studies.design.fit import Noisy, fit
from fenics_mech.studies.design.trial import Trials
from fenics_mech.views.identify_views import doubts, headline, identify_summary, plot_identified

ANGLES = np.linspace(0, 2 * np.pi, 90, endpoint=False)
UNKNOWN = np.array([np.nan])


def linear(matrix, measured, known=UNKNOWN, group=None):
    group = np.zeros(len(measured), dtype=int) if group is None else group
    start = np.full(matrix.shape[1], 0.4)
    return fit(lambda x: matrix @ x, lambda x: matrix, Noisy(measured, group, known), start, 1e-12)


def test_a_straight_line_has_the_covariance_of_the_textbook():
    x, rng = np.linspace(-1, 1, 40), np.random.default_rng(2)
    matrix = np.stack([np.ones(40), x], axis=1)
    found = linear(matrix, matrix @ [0.3, 0.6] + 0.02 * rng.normal(size=40))
    exact, rest, *_ = np.linalg.lstsq(matrix, found.data.values, rcond=None)
    np.testing.assert_allclose(found.at, exact, rtol=1e-7)
    square = rest[0] / 38
    np.testing.assert_allclose(np.diag(found.covariance), [square / 40, square / (x @ x)], rtol=1e-6)
    assert found.reach == pytest.approx(2.0244, abs=1e-4)  # Student's t of 38 degrees of freedom, table


def test_a_sum_is_told_and_its_parts_are_not():
    x = np.linspace(1, 2, 30)
    matrix = np.stack([x, x, x**3], axis=1)
    found = linear(matrix, matrix @ [0.2, 0.3, 0.5] + 1e-3 * np.random.default_rng(0).normal(size=30))
    assert found.told.tolist() == [False, False, True]
    np.testing.assert_allclose(np.abs(found.untold[:, 0]), [0.5**0.5, 0.5**0.5, 0], atol=1e-9)
    assert found.at[0] + found.at[1] == pytest.approx(0.5, abs=0.01)


def test_the_noise_of_each_record_is_estimated_by_itself():
    rng, matrix = np.random.default_rng(5), np.ones((400, 1))
    noise = np.repeat([1e-2, 1.0], 200)
    found = linear(matrix, 0.5 + noise * rng.normal(size=400), np.full(2, np.nan), np.repeat([0, 1], 200))
    np.testing.assert_allclose(found.noise, [1e-2, 1.0], rtol=0.15)  # three deviations of the estimate
    weights = 1 / found.noise[found.data.group] ** 2
    assert found.at[0] == pytest.approx(weights @ found.data.values / weights.sum(), rel=1e-4)


def coverage(predict, slopes, truth, noise):
    """How many of 100 noisy records have the truth within their interval."""
    exact, held = predict(truth), 0
    for seed in range(100):
        measured = exact + noise * np.random.default_rng(seed).normal(size=len(exact))
        found = fit(predict, slopes, Noisy(measured, np.zeros(len(exact), dtype=int), UNKNOWN), np.array([0.5]), 1e-9)
        held += abs(found.at[0] - truth[0]) <= found.reach * found.covariance[0, 0] ** 0.5
    return held


def oscillator(unit):
    """Response of an oscillator with a damping ratio up to 0.1 to nine harmonics of a drive, 8.5 times slower."""
    n = np.arange(1, 10)
    r = n / 8.5
    return (np.exp(1j * np.outer(ANGLES, n)) @ (1 / n / (1 - r**2 + 2j * 0.1 * unit[0] * r))).real


def test_damping_of_an_oscillator_is_within_its_interval_in_95_of_100_records():
    def slopes(x):
        return ((oscillator(x + 1e-6) - oscillator(x - 1e-6)) / 2e-6)[:, None]

    # of 100 intervals that each hold the truth with 0.95, 90 to 99 do with a chance of 0.98
    assert 90 <= coverage(oscillator, slopes, np.array([0.23]), 0.3) <= 99


def four_bar(**variables):
    scene = fm.load("demos/four_bar.toml").changed({"effects": ("coupling",), "analysis.sub_intervals": 120})
    return scene.changed(study={"variables": variables})


DAMPING = {"numbers": ["damping.ratio"], "between": [0.01, 0.04]}


@pytest.mark.slow
def test_damping_of_the_seed_is_within_its_interval_in_95_of_100_records():
    # the runs at Chebyshev points give the strain at any damping to 1e-6 of its peak
    curve = fm.Observation.curve("strain[coupler][@0.5][+]", ANGLES, np.zeros(90)).of
    trials = Trials.of(four_bar(damping=DAMPING), ())
    trials = Trials(trials.design, (curve,))
    points = (1 - np.cos(np.pi * (np.arange(12) + 0.5) / 12)) / 2
    runs = [curve.values(trial.numbers) for trial in trials.run([[0.01 + 0.03 * x] for x in points])]
    series = np.polynomial.chebyshev.Chebyshev.fit(points, np.array(runs).T[0], 11, domain=[0, 1])
    family = [series.fit(points, record, 11, domain=[0, 1]) for record in np.array(runs).T]
    rates = [one.deriv() for one in family]
    held = coverage(
        lambda x: np.array([one(x[0]) for one in family]),
        lambda x: np.array([[one(x[0])] for one in rates]),
        np.array([0.4]),
        5e-6,
    )
    assert 90 <= held <= 99


@pytest.mark.long
@pytest.mark.slow
def test_damping_and_stiffness_of_the_seed_are_found_from_a_noisy_strain(tmp_path):
    truth = fm.analyse(four_bar(damping=DAMPING).changed({"damping.ratio": 0.025, "materials.aluminium.modulus": 69e9}))
    strain = truth.strain_at("coupler")
    strain = strain + 4e-6 * np.random.default_rng(1).normal(size=len(strain))
    angles = np.degrees(truth.data["theta"].to_numpy())
    rows = "\n".join(f"{a},{e}" for a, e in zip(angles, strain))
    (tmp_path / "gauge.csv").write_text(f"angle_deg,strain\n{rows}\n")
    modulus = {"numbers": ["materials.aluminium.modulus"], "between": ["60 GPa", "80 GPa"]}
    gauge = fm.Measurement(file=tmp_path / "gauge.csv", member="coupler")
    scene = four_bar(damping=DAMPING, modulus=modulus).changed(measurements=(gauge,))
    found = fm.identify(scene, folder=tmp_path)
    assert (np.abs(found.values - [0.025, 69e9]) < 3 * found.deviation).all()
    assert (found.deviation < [5e-4, 1e8]).all()
    assert found.fit.noise[0] == pytest.approx(4e-6, rel=0.2)
    assert doubts(found) == []
    assert fm.load(tmp_path / "identified.toml").damping.ratio == pytest.approx(found.values[0])
    again = fm.identify(scene, folder=tmp_path)
    np.testing.assert_allclose(again.values, found.values, rtol=1e-9)


def quick(**variables):
    changes = {"analysis.method": "quasi-static", "analysis.sub_intervals": 36, "effects": ()}
    return four_bar(**variables).changed(changes)


MODULUS = {"numbers": ["materials.aluminium.modulus"], "between": ["40 GPa", "100 GPa"]}


def vibrating(**variables):
    return four_bar(**variables).changed(
        {"analysis.sub_intervals": 36, "effects": (), "analysis.solver": "collocation"}
    )


def frequency(scene):
    return Trials.of(scene, ["frequency[1].mean"]).run([[71e9]])[0].numbers["frequency[1].mean"]


@pytest.mark.slow
def test_a_frequency_tells_the_modulus_as_its_square(tmp_path):
    scene = vibrating(modulus=MODULUS)
    at_71 = frequency(scene)
    (tmp_path / "f.csv").write_text(f"number,value,deviation\nfrequency[1].mean,{0.98 * at_71},{0.01 * at_71}\n")
    found = fm.identify(scene, [tmp_path / "f.csv"], tmp_path)
    assert found.values[0] == pytest.approx(71e9 * 0.98**2, rel=1e-5)
    assert found.deviation[0] == pytest.approx(2 * 71e9 * 0.98 * 0.01, rel=1e-4)
    assert found.interval[0, 1] == pytest.approx(found.values[0] + 1.959964 * found.deviation[0])
    assert headline(found) == "The data tell modulus."
    identify_summary(found)
    assert [path.name for path in plot_identified(found, tmp_path)] == ["prediction_numbers.png"]
    assert (
        (tmp_path / "identified.csv")
        .read_text()
        .startswith("variable,unit,value,deviation,low,high,told\nmodulus,Pa,6")
    )


def test_modulus_and_density_are_not_told_apart_by_a_frequency():
    density = {"numbers": ["materials.aluminium.density"], "between": [2500, 2900]}
    scene = vibrating(modulus=MODULUS, density=density).changed(masses={})
    of = fm.Observation.number("frequency[1].mean", 47.0, 0.05)
    found = fm.identify(scene, [of, of])
    assert found.fit.told.tolist() == [True, False]
    assert headline(found).startswith("The data tell modulus, and not density.")
    # modulus over density is known well; the density may be anywhere in 400 kg/m^3
    share = 400 / 12**0.5 / found.values[1]
    assert found.deviation[0] == pytest.approx(found.values[0] * share, rel=0.03)
    assert np.isnan(found.deviation[1])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("angle,strain\n0,1e-4\n", "the header is not one of measured data"),
        ("angle_deg,torque,torque\n0,1,2\n", "the column 'torque' is there twice"),
        ("angle_deg,strian[coupler]\n0,1e-4\n", "Did you mean strain"),
        ("angle_deg,strain[coupler].max\n0,1e-4\n", "is one number, and no curve"),
        ("angle_deg,torque\n0,1\n10,x\n", "this line is not two finite numbers"),
        ("number,value,deviation\nfrequency[1].mean,44,0\n", "is not above 0"),
        ("number,value,deviation\nmass,44\n", "this line is not two finite numbers"),
        ("angle_deg,strain[coupler]\n0,1e-4\n10,1e-4\n", "Name its s and fibre in brackets"),
        ("angle_deg,strain[coupler][@0.5][+]\n0,140\n10,1e-4\n", "is no strain"),
        ("angle_deg,torque\n0,1\n", "too few for 1 variables"),
        ("angle_deg,torque\n0,1\n0,2\n0,3\n", "all angles of this curve are 0 deg"),
        ("angle_deg,torque\n0,1e308\n10,2\n", "the value 1e+308 of 'torque' is out of all range"),
        ("drive.sped,angle_deg,torque\n9,0,1\n9,10,2\n", "drive.sped"),
        ("materials.aluminium.modulus,angle_deg,torque\n7e10,0,1\n7e10,10,2\n", "which is a variable too"),
    ],
)
def test_bad_data_are_one_message(tmp_path, text, said):
    (tmp_path / "data.csv").write_text(text)
    with pytest.raises(SceneError) as caught:
        fm.identify(quick(modulus=MODULUS), [tmp_path / "data.csv"])
    assert said in str(caught.value)


def test_a_file_that_is_named_twice_is_refused(tmp_path, monkeypatch):
    scene = quick(modulus=MODULUS)
    (tmp_path / "data.csv").write_text("angle_deg,torque\n0,1\n10,2\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match="named twice"):
        fm.identify(scene, ["data.csv", tmp_path / "data.csv"])


def test_a_search_that_does_not_end_is_told(monkeypatch):
    matrix, x = np.ones((4, 1)), np.array([0.4, 0.5, 0.6, 0.5])
    assert linear(matrix, x).converged
    monkeypatch.setattr(optimize, "least_squares", partial(optimize.least_squares, max_nfev=1))
    assert not linear(matrix, x).converged


@pytest.mark.long
@pytest.mark.slow
def test_records_at_two_speeds_are_fitted_together(tmp_path):
    density = {"numbers": ["materials.aluminium.density"], "between": [2000, 3500]}
    modulus = {"numbers": ["materials.aluminium.modulus"], "between": ["50 GPa", "90 GPa"]}
    scene, rng = quick(density=density, modulus=modulus), np.random.default_rng(0)
    rows = ["drive.speed,angle_deg,torque,strain[coupler][@0.5][+]"]
    for speed in (20.0, 32.3):
        truth = {"drive.speed": speed, "materials.aluminium.density": 2600, "materials.aluminium.modulus": 68e9}
        result = fm.analyse(scene.changed(truth).changed({"analysis.error_estimates": False}))
        torque = result.data["input_torque"].to_numpy() + 1e-3 * rng.normal(size=36)
        strain = result.strain_at("coupler") + 1e-7 * rng.normal(size=36)
        rows += [f"{speed},{10 * k},{a},{e}" for k, (a, e) in enumerate(zip(torque, strain))]
    (tmp_path / "two.csv").write_text("\n".join(rows) + "\n")
    found = fm.identify(scene, [tmp_path / "two.csv"], tmp_path)
    assert (np.abs(found.values - [2600, 68e9]) < 3 * found.deviation).all()
    assert [one.at for one in found.observations] == [{"drive.speed": speed} for speed in (20.0, 20.0, 32.3, 32.3)]
    assert found.observations[0].text == "torque at drive.speed = 20"
    assert found.first.shape == found.fit.predicted.shape == (144,)
    assert found.scene.drive.speed == scene.drive.speed
    identify_summary(found)
    assert len(plot_identified(found, tmp_path)) == 4


@pytest.mark.long
@pytest.mark.slow
def test_clearance_and_friction_are_found_from_the_push_and_the_torque():
    law = {"kind": "friction", "joint": "A", "coefficient": 0.1, "radius": "10 mm"}
    contact = {"restitution": 0.1, "stiffness": 1e6}
    scene = fm.load("demos/joint_laws/rattling_slider_crank.toml").changed(
        {
            "drive.speed": "600 rpm",
            "analysis.sub_intervals": 36,
            "joint_laws.rubbing": law,
            **{f"joint_laws.rattle.contact.{key}": value for key, value in contact.items()},
        }
    )
    data = fm.analyse(scene).data
    push, torque = float(data["largest_law_effort"].sel(law="rattle")), float(data["input_torque"].mean())
    variables = {
        "friction": {"numbers": ["joint_laws.rubbing.coefficient"], "between": [0.02, 0.3], "start": 0.15},
        "clearance": {"numbers": ["joint_laws.rattle.radial"], "between": ["0.2 mm", "1 mm"], "start": "0.3 mm"},
    }
    measured = [("largest_law_effort[rattle].max", push, 1.0), ("torque.mean", torque, 2e-3)]
    found = fm.identify(
        scene.changed(study={"variables": variables}), [fm.Observation.number(*one) for one in measured]
    )
    np.testing.assert_allclose(found.values, [0.1, 0.5e-3], rtol=1e-3)
    assert found.fit.told.all()


def test_without_data_or_with_choices_nothing_is_searched():
    with pytest.raises(SceneError, match="there are no measured data"):
        fm.identify(quick(modulus=MODULUS))
    choice = {"numbers": ["links.coupler.members.AB.section"], "choices": ["strip", "crank"]}
    with pytest.raises(SceneError, match="take no choices"):
        fm.identify(quick(section=choice), [fm.Observation.number("mass", 1.0, 0.1)])


@pytest.mark.slow
def test_differences_that_are_no_noise_are_told():
    modelled = fm.analyse(quick(modulus=MODULUS).changed({"analysis.error_estimates": False}))
    curve = modelled.strain_at("coupler") + 2e-6 * np.sin(3 * modelled.data["theta"].to_numpy())
    of = fm.Observation.curve("strain[coupler][@0.5][+]", modelled.data["theta"].to_numpy(), curve)
    found = fm.identify(quick(modulus=MODULUS), [of])
    assert any("follow one another" in line for line in doubts(found))


def test_a_number_that_no_variable_moves_is_said():
    damping = {"numbers": ["damping.ratio"], "between": [0.002, 0.1]}
    scene = fm.load("demos/four_bar.toml").changed(study={"variables": {"damping": damping}}, effects=())
    scene = scene.changed({"analysis.solver": "collocation", "analysis.sub_intervals": 24})
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # as SciPy's search warns that it divides by 0
        with pytest.raises(SceneError, match="none of their numbers changes with damping"):
            fm.identify(scene, [fm.Observation.number("mass", 43.7, 1.0)])
