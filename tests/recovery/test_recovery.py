"""Section forces, joint forces and results as files."""

import numpy as np
import pytest
import xarray as xr

from fenics_mech import Result, analyse, load
from fenics_mech.errors import ResultError
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.variables import with_units
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS, response_of
from tests.validation.reference.mecqbar import mecqbar


@pytest.fixture(scope="module")
def periodic():
    return analyse(seed_four_bar(analysis={"sub_intervals": 96}))


@pytest.fixture(scope="module")
def quasi_static():
    return analyse(seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24}))


def test_laws_along_slides_exert_forces_and_those_at_pins_moments():
    rubbing = {"kind": "friction", "coefficient": 0.1}
    laws = {"A": {**rubbing, "joint": "A", "radius": 0.01}, "B": {**rubbing, "joint": "B"}}
    scene = load(DEMOS / "slider_crank.toml").changed({"joint_laws": laws, "analysis.method": "transient"})
    for name, unit in (("A", "N m"), ("B", "N")):
        data = xr.Dataset({"law_effort": (("theta", "law"), [[1.0]])}, {"theta": [0.0], "law": [name], "time": 0.0})
        assert with_units(scene, data)["law_effort"].attrs["units"] == unit


def test_quasi_static_joint_forces_are_mecqbars(quasi_static):
    printed = mecqbar(quasi_static.data["theta"].to_numpy())
    force = quasi_static.data["joint_force"]
    on_coupler_a, on_follower_b = (force.sel(joint=j).to_numpy() for j in ("A", "B"))
    assert np.allclose(on_coupler_a, np.stack([printed["XA_N"], printed["YA_N"]], 1), rtol=0, atol=1e-9)
    assert np.allclose(on_follower_b, -np.stack([printed["XB_N"], printed["YB_N"]], 1), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ({"member": "nope"}, "no member 'nope'; it has crank, coupler, follower"),
        ({"member": "crank", "fibre": "top"}, r"no fibre 'top'; it has \+, -"),
        ({"member": "crank", "s": 1.2}, "s = 1.2 is no place"),
        ({"member": "crank", "s": np.nan}, "s = nan is no place"),
    ],
)
def test_a_strain_where_there_is_none_is_refused(quasi_static, place, message):
    with pytest.raises(ResultError, match=message):
        quasi_static.strain_at(**place)


def test_strains_are_interpolated_between_stations(quasi_static):
    """With every second station only, the strains at the others are found again; straight lines are off by 1 %."""
    strain = quasi_static.data["strain"].sel(member="coupler", fibre="-").transpose("theta", "s")
    few = Result(quasi_static.data.isel(s=slice(None, None, 2)))
    for s in (0.0, 0.5, 1.0):
        np.testing.assert_array_equal(few.strain_at("coupler", s, "-"), strain.sel(s=s))
    off = {
        kind: max(np.abs(found(s) - strain.sel(s=s).to_numpy()).max() for s in strain["s"].to_numpy()[1::2])
        / float(np.abs(strain).max())
        for kind, found in {
            "curve": lambda s: few.strain_at("coupler", s, "-"),
            "lines": lambda s: few.data["strain"].sel(member="coupler", fibre="-").interp(s=s).to_numpy(),
        }.items()
    }
    assert off["curve"] < 2e-3 < 5e-3 < off["lines"]


def test_a_jump_along_a_member_is_felt_between_its_two_stations_alone():
    """The moment of a couple at s = 0.42: a spline was off by 15 % of the jump in the next interval."""
    stations, places = np.linspace(0, 1, 21), np.array([0.175, 0.375, 0.475, 0.525, 0.775])
    found = at_place((stations > 0.42) - stations, stations, places)
    assert found == pytest.approx((places > 0.42) - places, abs=1e-12)


def test_between_two_stations_a_curve_is_straight():
    curves = np.array([[1.0, 3.0], [-2.0, 2.0]])
    assert at_place(curves, np.array([0.0, 1.0]), 0.25) == pytest.approx([1.5, -1.0])
    assert at_place(curves, np.array([0.0, 1.0]), np.array([0.25, 0.5])) == pytest.approx(
        np.array([[1.5, 2.0], [-1.0, 0.0]])
    )


def test_input_torque_is_the_rate_of_kinetic_energy(quasi_static):
    # virtual work: torque omega_1 = d/dt of the kinetic energy of the rigid linkage
    def energy(theta):
        row = mecqbar(theta)
        m2, m3, m_b, b, c = 0.030787, 0.029808, 0.03755, 0.2794, 0.27051
        m2, m3 = 2714 * 4.06e-5 * b, 2714 * 4.06e-5 * c
        th2, w1, w2, w3 = row["theta2_rad"], 32.3, row["omega2_rad_s"], row["omega3_rad_s"]
        vx = -0.10795 * w1 * np.sin(theta) - b / 2 * w2 * np.sin(th2)
        vy = 0.10795 * w1 * np.cos(theta) + b / 2 * w2 * np.cos(th2)
        return m2 * (vx**2 + vy**2) / 2 + m2 * b**2 / 24 * w2**2 + (m3 / 3 + m_b) * c**2 / 2 * w3**2

    theta, h = quasi_static.data["theta"].to_numpy(), 1e-4
    rate = (energy(theta + h) - energy(theta - h)) / (2 * h)  # dT/dtheta
    assert np.allclose(quasi_static.data["input_torque"], rate, rtol=0, atol=1e-7 * np.abs(rate).max())


def test_ends_on_pins_carry_no_moment(periodic):
    moment = periodic.data["moment"]
    peak = float(np.abs(moment).max())
    for member, s in (("crank", 1), ("coupler", 0), ("coupler", 1), ("follower", 0), ("follower", 1)):
        assert np.abs(moment.sel(member=member, s=s)).max() < 1e-9 * peak


def test_joint_force_is_the_members_end_force(periodic):
    # axial and shear force at the coupler's first end, turned into the fixed frame, balance the force of pin A
    from fenics_mech.machine.linkage import solve_motion

    angle = solve_motion(periodic.scene, periodic.data["theta"].to_numpy()).angle[:, 1]
    end = periodic.data.sel(member="coupler", s=0)
    n, v = end["axial_force"].to_numpy(), end["shear_force"].to_numpy()
    force = np.stack([-n * np.cos(angle) - v * np.sin(angle), -n * np.sin(angle) + v * np.cos(angle)], axis=1)
    found = periodic.data["joint_force"].sel(joint="A").to_numpy()
    assert np.allclose(found, force, rtol=0, atol=1e-9 * np.abs(found).max())


def test_moment_is_continuous_over_elements():
    scene = seed_four_bar(analysis={"sub_intervals": 96, "stations": 301}, mesh={"elements": 3})
    moment = analyse(scene).data["moment"].sel(member="coupler").to_numpy()
    third = np.abs(np.diff(moment, n=2, axis=1))
    assert third.max() < 1e-3 * np.abs(moment).max()  # a jump at s = 1/3 would stand out by orders of magnitude


def test_strain_is_axial_plus_bending_and_stress_follows(quasi_static):
    data = quasi_static.data
    assert np.allclose(data["strain"], data["strain_axial"] + data["strain_bending"], rtol=1e-12, atol=1e-18)
    assert np.allclose(data["stress"], 71e9 * data["strain"], rtol=1e-12)
    bending = data["strain_bending"]
    assert np.allclose(bending.sel(fibre="+"), -bending.sel(fibre="-"), rtol=1e-12)
    assert np.allclose(
        bending.sel(fibre="+", member="coupler"), -8e-4 / (71e9 * 8.67e-12) * data["moment"].sel(member="coupler")
    )


def damped(**damping):
    """Stress less modulus times strain, and both, of a linear motion with some damping, ``(angles, ...)``."""
    scene = seed_four_bar(drive={"joint": "O", "speed": 20.0}, effects=["coupling"], damping=damping)
    options = {"sub_intervals": 60, "modes": 2, "stability": False}
    data = response_of(scene.changed(analysis=options)).data
    stress, strain = (data[name].transpose("theta", ...).to_numpy() for name in ("stress", "strain"))
    modulus = next(iter(scene.materials.values())).modulus
    return stress - modulus * strain, stress, modulus * strain, scene.period


def test_stress_and_strain_differ_by_what_damps():
    """Nothing without damping; by the ratio in proportion to it; by the material its time times the strain's rate."""
    apart, stress, *_ = damped()
    assert np.abs(apart).max() < 1e-12 * np.abs(stress).max()
    shares = []
    for ratio in (0.01, 0.02):
        apart, stress, *_ = damped(ratio=ratio)
        shares.append(np.abs(apart).max() / np.abs(stress).max())
    assert 0.002 < shares[0] < 0.02
    assert shares[1] == pytest.approx(2 * shares[0], rel=0.1)  # the motion hardly changes
    apart, stress, elastic, period = damped(material=1e-4)
    rate = 2j * np.pi / period * np.fft.fftfreq(len(elastic), 1 / len(elastic))[:, None, None, None]
    viscous = 1e-4 * np.fft.ifft(rate * np.fft.fft(elastic, axis=0), axis=0).real
    assert apart == pytest.approx(viscous, abs=1e-3 * np.abs(viscous).max())


def test_static_deflection_of_one_element_is_that_of_many():
    coarse, fine = (
        analyse(
            seed_four_bar(
                mesh={"elements": n}, analysis={"method": "quasi-static", "sub_intervals": 8, "allow_coarse": True}
            )
        )
        for n in (1, 40)
    )
    difference = np.abs(coarse.data["deflection"] - fine.data["deflection"]).max()
    assert difference < 1e-5 * np.abs(fine.data["deflection"]).max()  # inertia along elements: 5 % of the stretch


def test_result_survives_saving(periodic, tmp_path):
    loaded = Result.load(periodic.save(tmp_path / "result.nc"))
    xr.testing.assert_identical(loaded.data, periodic.data)
    assert loaded.scene == periodic.scene
    assert [p.name for p in tmp_path.iterdir()] == ["result.nc"]


def test_csv_holds_the_numbers(periodic, tmp_path):
    paths = periodic.to_csv(tmp_path / "tables")
    assert {p.stem for p in paths} == set(periodic.data.data_vars)
    table = np.genfromtxt(tmp_path / "tables" / "input_torque.csv", delimiter=",", names=True)
    assert np.allclose(table["input_torque_N_m"], periodic.data["input_torque"], rtol=1e-12)


@pytest.mark.parametrize(("most", "points", "kind"), [(2**31, 3, b"CDF"), (23, 3, b"\x89HDF"), (2**31, 0, b"\x89HDF")])
def test_netcdf_of_either_kind_is_saved_and_loaded(most, points, kind, tmp_path, monkeypatch):
    """NetCDF 3 has no large variables, and none without values; version 0.2 saved all results as NetCDF 4."""
    monkeypatch.setattr("fenics_mech.recovery.saved.LARGEST_VARIABLE", most)
    given = {"a": ("x", np.arange(float(points))), "b": ("y", ["", "\u00e4", "abc"]), "c": ("z", [1, 2])}
    path = Result(xr.Dataset(given, attrs={"fenics_mech": "1", "scene": "{}"})).save(tmp_path / "result.nc")
    assert path.read_bytes().startswith(kind)
    xr.testing.assert_identical(Result.load(path).data, xr.Dataset(given, attrs={"fenics_mech": "1", "scene": "{}"}))


@pytest.mark.parametrize(
    ("stated", "values"),
    [
        ({"labels": ["hot", "cold"]}, np.arange(3.0)),
        ({"count": 2**40}, np.arange(3.0)),
        ({"counts": [1, 2**40]}, np.arange(3.0)),
        ({"table": np.eye(2)}, np.arange(3.0)),
        ({}, np.array([1.0 + 2.0j])),
    ],
)
def test_what_netcdf_3_lacks_is_saved_and_read_back(stated, values, tmp_path):
    data = xr.Dataset({"a": ("x", values)}, attrs={"fenics_mech": "1", "scene": "{}"} | stated)
    path = Result(data).save(tmp_path / "result.nc")
    assert path.read_bytes().startswith(b"\x89HDF")
    xr.testing.assert_identical(Result.load(path).data, data)


@pytest.mark.parametrize(
    ("stated", "read"),
    [
        (np.bool_(True), 1),
        (False, 0),
        (np.array([True, False]), [1, 0]),
        (np.array(["hot", "\u00e4"]), ["hot", "\u00e4"]),
    ],
)
def test_truths_and_arrays_of_texts_are_saved_as_what_netcdf_has(stated, read, tmp_path):
    given = {"a": ("x", np.arange(3.0), {"of_variable": stated})}
    data = xr.Dataset(given, attrs={"fenics_mech": "1", "scene": "{}", "of_all": stated})
    loaded = Result.load(Result(data).save(tmp_path / "result.nc")).data
    for found in (loaded.attrs["of_all"], loaded["a"].attrs["of_variable"]):
        assert np.array_equal(found, read)
    assert data.attrs["of_all"] is stated
    assert data["a"].attrs["of_variable"] is stated


@pytest.mark.parametrize(
    ("stated", "named"),
    [({"note": {"a": 1}}, "attribute 'note'"), ({"mixed": ["a", 1]}, "attribute 'mixed'"), ({}, "variable 'b'")],
)
def test_what_no_netcdf_has_a_form_for_is_named(stated, named, tmp_path):
    given = {"a": ("x", np.arange(3.0))} | ({} if stated else {"b": ("y", np.array([{}, {}]))})
    with pytest.raises(ResultError, match=rf"result\.nc: NetCDF has no form for {named} of this result"):
        Result(xr.Dataset(given, attrs={"fenics_mech": "1", "scene": "{}"} | stated)).save(tmp_path / "result.nc")
    assert list(tmp_path.iterdir()) == []


def test_unwritable_folder_leaves_nothing(periodic, tmp_path):
    with pytest.raises(ResultError, match="cannot be written"):
        periodic.save(tmp_path / "missing" / "result.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [b"", b"not a netcdf file"])
def test_foreign_file_is_refused(tmp_path, content):
    (tmp_path / "other.nc").write_bytes(content)
    with pytest.raises(ResultError, match=r"other\.nc"):
        Result.load(tmp_path / "other.nc")


def test_netcdf_of_another_program_is_refused(tmp_path):
    xr.Dataset({"a": 1}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(ResultError, match="not a result of fenics_mech"):
        Result.load(tmp_path / "other.nc")


def test_same_scene_gives_the_same_bits(periodic):
    again = analyse(seed_four_bar(analysis={"sub_intervals": 96}))
    xr.testing.assert_identical(again.data, periodic.data)


def test_limits_of_the_linear_theory_are_measured(quasi_static):
    axial = np.abs(quasi_static.data["axial_force"]).max(("theta", "s")).to_numpy()
    euler = np.pi**2 * 71e9 * np.array([1.62e-10, 8.67e-12, 8.67e-12]) / np.array([0.10795, 0.2794, 0.27051]) ** 2
    assert np.allclose(quasi_static.data["euler_ratio"], axial / euler, rtol=1e-12)
    # the bow of a member is its deflection across, from its chord: at most 5 q L^4/(384 EI) with its peak load here
    bow = quasi_static.data["bow"].sel(member="coupler")
    curvature = np.abs(quasi_static.data["moment"].sel(member="coupler")).max() / (71e9 * 8.67e-12)
    assert float(bow) == pytest.approx(float(curvature) * 0.2794 / np.pi**2, rel=0.05)


def test_named_variables_are_those_of_the_whole_result(seed):
    """Whatever else is left out; errors and multipliers come with them."""
    scene = seed.changed({"effects": ["coupling"], "analysis.sub_intervals": 60, "analysis.allow_coarse": True})
    names = ("strain", "input_torque", "frequency", "multiplier", "shaking_force")
    whole, found = analyse(scene).data, analyse(scene, names=names).data
    assert set(names) | {"relative_error"} <= set(found.data_vars) < set(whole.data_vars)
    for name in found.variables:
        assert found[name].variable.identical(whole[name].variable)
    assert found.attrs.items() <= whole.attrs.items()
