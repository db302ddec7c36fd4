"""Sobol indices of functions with known ones, and the scatter of masses and frequencies against closed forms."""

import math

import numpy as np
import pytest
from scipy.stats import truncnorm

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.studies.design.chaos import polynomial_chaos
from fenics_mech.studies.design.explorer import Explorer
from fenics_mech.studies.design.scatter import SAMPLINGS, Scattered, drawn
from fenics_mech.studies.design.sobol_indices import saltelli_points, sobol_indices
from fenics_mech.studies.design.spread import statistics
from fenics_mech.studies.design.trial import Trial
from fenics_mech.views.spread_views import _notes, headline, plot_spread, spread_summary

# Ishigami function with a = 7, b = 0.1: Saltelli, Chan and Scott, Sensitivity Analysis, 2000, page 41
A, B = 7.0, 0.1
V1, V2 = 0.5 * (1 + B * math.pi**4 / 5) ** 2, A**2 / 8
V13 = 8 * B**2 * math.pi**8 / 225
VARIANCE = V1 + V2 + V13


def ishigami(points):
    x = np.pi * (2 * points - 1)
    return np.sin(x[..., 0]) + A * np.sin(x[..., 1]) ** 2 + B * x[..., 2] ** 4 * np.sin(x[..., 0])


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_indices_of_the_ishigami_function_are_the_known_ones(sampling):
    points = saltelli_points(drawn(sampling, 2**14, 6, seed=3))
    found = sobol_indices(ishigami(points))
    near = 0.003 if sampling == "sobol" else 0.03  # errors fall as 1/N, or as 1/sqrt(N)
    np.testing.assert_allclose(found.first, np.array([V1, V2, 0]) / VARIANCE, atol=near)
    np.testing.assert_allclose(found.total, np.array([V1 + V13, V2, V13]) / VARIANCE, atol=near)
    assert (found.doubt < 0.05).all()


def test_polynomials_give_the_indices_of_the_ishigami_function_from_few_samples():
    points = drawn("sobol", 1024, 3, seed=3)
    found = polynomial_chaos(points, ishigami(points), np.zeros(3, dtype=bool))
    assert found.degree == 12
    assert found.left < 1e-4
    near = 1e-3  # fourteen times as many analyses by Saltelli's samples: 3e-3
    np.testing.assert_allclose(found.first, np.array([V1, V2, 0]) / VARIANCE, atol=near)
    np.testing.assert_allclose(found.total, np.array([V1 + V13, V2, V13]) / VARIANCE, atol=near)
    assert (found.mean, found.deviation) == pytest.approx((A / 2, VARIANCE**0.5), rel=1e-3)


def test_polynomials_of_a_cut_normal_distribution_have_its_moments():
    chance = drawn("sobol", 64, 2, seed=0)
    normal = truncnorm.ppf(chance[:, 0], -4, 4)
    places = np.stack([0.5 + normal / 8, chance[:, 1]], axis=1)
    found = polynomial_chaos(places, normal**2 + 3 * chance[:, 1], np.array([True, False]))
    second, fourth = (truncnorm.moment(order, -4, 4) for order in (2, 4))
    assert (found.degree, found.left) == (2, pytest.approx(0, abs=1e-20))
    assert found.mean == pytest.approx(second + 1.5, rel=1e-9)
    assert found.deviation**2 == pytest.approx(fourth - second**2 + 0.75, rel=1e-9)
    assert found.first.sum() == pytest.approx(1)


def test_samples_too_few_or_without_scatter_have_no_polynomials():
    points = drawn("sobol", 4, 3, seed=0)
    none = np.zeros(3, dtype=bool)
    assert polynomial_chaos(points, ishigami(points), none) is None
    assert polynomial_chaos(drawn("sobol", 64, 3, seed=0), np.ones(64), none) is None


def test_a_derivative_between_trials_that_failed_is_not_known():
    class Failing:
        why_differences = "they are formulas"
        design = type("Bounds", (), {"bounds": [(0.0, 1.0)] * 2, "variables": [type("V", (), {"choices": ()})] * 2})

        def run(self, points, progress):
            for x, y in points:
                failed = abs(x - 0.5) > 1e-9
                progress(Trial((x, y), {"f": math.nan if failed else x + 3 * y}, "Error" * failed, "", 0.0))
            return [Trial((x, y), {"f": x + 3 * y}, "Error" * (abs(x - 0.5) > 1e-9), "", 0.0) for x, y in points]

    found = Explorer(Failing()).derivatives(np.array([0.5, 0.5]))["f"]
    assert np.isnan(found[0])
    assert found[1] == pytest.approx(3)


def test_samples_that_failed_are_left_out_of_indices():
    values = ishigami(saltelli_points(drawn("sobol", 1024, 6, seed=1)))
    kept = values.copy()
    kept[::50, 3] = np.nan
    without = np.delete(values, np.arange(0, 1024, 50), axis=0)
    np.testing.assert_array_equal(sobol_indices(kept).first, sobol_indices(without).first)


def scene_of(scatter, **study):
    scene = fm.load("demos/four_bar.toml").changed(masses={})
    return scene.changed(study={"scatter": scatter, **study})


AREA = {"numbers": ["sections.strip.area"], "tolerance": "10 %"}
DENSITY = {"numbers": ["materials.aluminium.density"], "deviation": "50 kg/m^3"}


def test_a_product_has_the_moments_and_shares_of_its_closed_form(tmp_path):
    found = fm.spread(
        scene_of({"a": AREA, "rho": DENSITY}, results=["mass[coupler]"]), tmp_path, samples=128, indices=True
    )
    area, density, length = 0.406e-4, 2714.0, 11 * 0.0254
    part = np.array([0.1 / math.sqrt(3), 50 / 2714]) ** 2  # variances over the means squared
    variance = (1 + part).prod() - 1
    nominal, mean, deviation, linear, *_, high = statistics(found, "mass[coupler]")
    mass = area * density * length
    assert nominal == pytest.approx(mass, rel=1e-12)
    assert mean == pytest.approx(mass, rel=1e-3)
    assert deviation == pytest.approx(mass * math.sqrt(variance), rel=0.02)
    assert linear == pytest.approx(mass * math.sqrt(part.sum()), rel=2e-3)  # the normal one is cut at four deviations
    assert high < 1.1 * mass * (1 + 2 * 50 / 2714)
    one = found.indices["mass[coupler]"]
    np.testing.assert_allclose(one.first, part / variance, atol=0.02)
    np.testing.assert_allclose(one.total, (part + part.prod()) / variance, atol=0.02)
    np.testing.assert_allclose(found.linear_shares("mass[coupler]"), part / part.sum(), atol=2e-3)
    chaos = found.chaos["mass[coupler]"]
    np.testing.assert_allclose(chaos.first, part / variance, atol=2e-3)
    assert chaos.deviation == pytest.approx(mass * math.sqrt(variance), rel=2e-3)
    assert {"spread.csv", "samples.csv", "indices.csv", "polynomials.csv"} <= {path.name for path in tmp_path.iterdir()}
    again = fm.spread(
        scene_of({"a": AREA, "rho": DENSITY}, results=["mass[coupler]"]), tmp_path, samples=128, indices=True
    )
    np.testing.assert_array_equal(again.data["result"], found.data["result"])


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_the_yield_is_that_of_the_normal_distribution(sampling):
    mass = 0.406e-4 * 2714 * 11 * 0.0254
    limits = [{"of": "mass[coupler]", "most": mass * (1 + 50 / 2714)}]  # one deviation above the mean
    found = fm.spread(scene_of({"rho": DENSITY}, limits=limits), samples=256, sampling=sampling)
    share, low, high = found.kept()
    assert share == pytest.approx(0.8413, abs=0.006)
    assert low < 0.8413 < high
    assert headline(found).startswith("84")


@pytest.mark.long
@pytest.mark.slow
def test_bands_of_a_curve_and_quantiles_are_those_of_the_closed_form(tmp_path):
    # without masses of bearings, quasi-static strains are in proportion to the density
    quick = {"analysis.method": "quasi-static", "analysis.sub_intervals": 36, "effects": ()}
    study = {"results": ["strain[coupler].max"], "curves": ["strain[coupler][@0.5][+]"]}
    found = fm.spread(scene_of({"rho": DENSITY}, **study).changed(quick), tmp_path, samples=32)
    curves = found.data["curve"].isel(of=0).to_numpy()
    shares = found.data["value"].to_numpy()[:, 0] / 2714
    nominal = found.curves[0].values(found.explorer.first.numbers)
    np.testing.assert_allclose(curves, shares[:, None] * nominal, atol=1e-9 * np.abs(nominal).max())
    nominal, _, deviation, *_, high = statistics(found, "strain[coupler].max")
    assert deviation == pytest.approx(nominal * 50 / 2714, rel=0.05)
    assert high == pytest.approx(nominal * (1 + 1.645 * 50 / 2714), rel=3e-3)
    spread_summary(found)
    assert [path.name for path in plot_spread(found, tmp_path)] == ["distributions.png", "band_1.png", "shares.png"]


def test_rounding_is_no_scatter_and_no_samples_have_no_yield():
    damping = {"numbers": ["damping.ratio"], "between": [0.01, 0.02]}  # on which the mass does not depend
    found = fm.spread(scene_of({"zeta": damping}, results=["mass[coupler]"]), samples=4)
    found.contributions["mass[coupler]"][:] = 1e-18  # as differences may give
    assert not _notes(found)
    without = fm.spread(scene_of({"a": AREA}, results=["mass[coupler]"]), samples=0)
    assert np.isnan(without.kept()).all()


@pytest.mark.slow
def test_samples_that_cannot_be_assembled_keep_no_limit(tmp_path):
    quick = {"analysis.method": "quasi-static", "analysis.sub_intervals": 36, "effects": ()}
    ground = {"numbers": ["ground.points.C.0"], "between": ["9 in", "20 in"]}  # 17.4 in is the longest that turns
    study = {"limits": [{"of": "strain.max", "most": 1.0}]}
    found = fm.spread(scene_of({"ground": ground}, **study).changed(quick), tmp_path, samples=16, jobs=2)
    long = found.data["value"].to_numpy()[:, 0] > (11 + 10.65 - 4.25) * 0.0254
    assert np.array_equal([trial.failed for trial in found.samples], long)
    assert found.kept()[0] == pytest.approx(1 - long.mean())


def test_a_normal_distribution_is_cut_and_has_its_quantiles():
    found = Scattered.of(scene_of({"rho": DENSITY}))
    assert found.design.bounds == [(2514.0, 2914.0)]
    assert found.values(np.array([0.5]))[0] == pytest.approx(2714)
    assert found.values(np.array([0.8413447]))[0] == pytest.approx(2764, abs=0.02)
    assert found.deviations[0] == pytest.approx(50, rel=1e-3)


@pytest.mark.parametrize(
    ("scatter", "said"),
    [
        ({"numbers": ["materials.aluminium.density"]}, "state one of"),
        ({"numbers": ["materials.aluminium.density"], "deviation": 5, "tolerance": 5}, "state one of"),
        ({"numbers": ["materials.aluminium.densty"], "deviation": 5}, "Did you mean materials.aluminium.density"),
        ({"numbers": ["materials.aluminium.density"], "deviation": "5 mm"}, "cannot read the departure"),
        ({"numbers": ["materials.aluminium.density"], "deviation": -5}, "is not above 0"),
        ({"numbers": ["materials.aluminium.density"], "deviation": "30 %"}, "density"),
        ({"numbers": ["damping.ratio"], "between": [0.03, 0.02]}, "is not below"),
    ],
)
def test_a_bad_distribution_is_one_message_with_its_place(scatter, said):
    with pytest.raises(SceneError, match="scatter") as caught:
        fm.spread(scene_of({"x": scatter}, results=["mass"]), samples=4)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("study", "options", "said"),
    [
        ({"results": ["mass"]}, {"sampling": "halton"}, "no sampling 'halton'"),
        ({"results": ["mass"]}, {"samples": 10**6, "indices": True}, "at most"),
        ({}, {}, "looks at no number"),
        ({"curves": ["mass"]}, {}, "no curve over the drive angle"),
    ],
)
def test_a_bad_study_is_one_message(study, options, said, tmp_path):
    with pytest.raises(SceneError) as caught:
        fm.spread(scene_of({"rho": DENSITY}, **study), tmp_path, **options)
    assert said in str(caught.value)
    assert not list(tmp_path.iterdir())  # no trial before


@pytest.mark.parametrize("led", [False, True])
def test_each_sample_counts_once_as_it_is_known(led, tmp_path, monkeypatch):
    module = "fenics_mech.studies.design.trial"
    monkeypatch.setattr(f"{module}.leads", lambda: led)
    ended, counts = [], []

    def over_machines(tasks, work, done):
        for task in tasks:
            done(task, work(task))
            ended.append(len(counts))

    monkeypatch.setattr(f"{module}.over_machines", over_machines)
    speed = {"speed": {"numbers": ["drive.speed"], "tolerance": "5 %"}}
    scene = fm.load("demos/four_bar.toml").changed(study={"scatter": speed, "results": ["mass"]})
    for samples in (4, 8):  # the first four are known then
        counts.clear()
        fm.spread(scene, tmp_path, samples=samples, progress=counts.append)
        assert counts == list(range(1, samples + 1))
    assert ended[-4:] == [1, 2, 3, 4] if led else not ended
