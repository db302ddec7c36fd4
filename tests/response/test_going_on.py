"""Motions in time that go on from another result, and those that start on the slow motion."""

import numpy as np
import pytest

import fenics_mech as fm
from tests.joints.scenes import bar
from tests.response import test_free_motion as bent
from tests.response.test_rigid_motion import bars, slider_crank


def halves(scene, file, steps):
    """The second half of a motion, and what goes on from the end of the first half."""
    whole = fm.analyse(scene.changed({"analysis.duration": 0.4, "analysis.sub_intervals": 2 * steps})).data
    half = scene.changed({"analysis.duration": 0.2, "analysis.sub_intervals": steps})
    fm.analyse(half).save(file)
    goes_on = fm.analyse(half.changed({"analysis.start": str(file)}))
    np.testing.assert_allclose(goes_on.data["time"], whole["time"][steps:], rtol=1e-12)
    return whole.isel(theta=slice(steps, None)), goes_on.data


def test_a_motion_of_rigid_links_goes_on_from_its_end_and_from_any_position(tmp_path):
    push = {"kind": "formula", "formula": "2*sin(20*t)"}
    scene = bars(2, 1e-9, duration=0.4).changed(
        {"freedoms": {"P1": {"effort": push}}, "analysis.error_estimates": False}
    )
    whole, goes_on = halves(scene, tmp_path / "half.nc", 4)
    for name in ("freedom_place", "freedom_rate", "joint_force", "link_angle"):
        np.testing.assert_allclose(goes_on[name], whole[name], rtol=0, atol=1e-7)
    assert goes_on.attrs["power_balance_error"] < 1e-8
    changes = {"analysis.start": str(tmp_path / "half.nc"), "analysis.start_time": "0.1 s", "analysis.duration": 0.3}
    from_middle = fm.analyse(scene.changed({**changes, "analysis.sub_intervals": 6})).data
    np.testing.assert_allclose(from_middle["time"][[0, -1]], [0.1, 0.4], rtol=1e-12)
    np.testing.assert_allclose(from_middle["freedom_place"][-1], whole["freedom_place"][-1], atol=1e-7)


def test_beside_a_drive_the_drive_goes_on_too(tmp_path):
    led = {"drive": {"joint": "P0", "speed": 4 * np.pi}, "analysis.cycles": 1, "analysis.sub_intervals": 4}
    scene = bars(2, 1e-9).changed({**led, "analysis.error_estimates": False})
    fm.analyse(scene).save(tmp_path / "one.nc")
    second = fm.analyse(scene.changed({"analysis.start": str(tmp_path / "one.nc")})).data
    whole = fm.analyse(scene.changed({"analysis.cycles": 2})).data
    np.testing.assert_allclose(second["theta"], whole["theta"][4:], rtol=1e-12)
    np.testing.assert_allclose(second["freedom_place"], whole["freedom_place"][4:], atol=1e-6)
    np.testing.assert_allclose(second["input_torque"], whole["input_torque"][4:], atol=1e-5)


def test_beside_a_drive_of_another_speed_it_does_not_go_on(tmp_path):
    led = {"drive": {"joint": "P0", "speed": 4 * np.pi}, "analysis.cycles": 1, "analysis.sub_intervals": 4}
    scene = bars(2, 1e-5).changed({**led, "analysis.error_estimates": False})
    fm.analyse(scene).save(tmp_path / "one.nc")
    faster = {"analysis.start": str(tmp_path / "one.nc"), "drive": {"joint": "P0", "speed": 8 * np.pi}}
    with pytest.raises(fm.SceneError, match="at drive angle 360 deg, where the scene's drive is at 720 deg"):
        fm.analyse(scene.changed(faster))


def test_a_machine_whose_motor_is_switched_off_coasts(tmp_path):
    stall, idle, brake, spun, inertia = 3.0, 40.0, 0.05, 0.5, 1 / 3
    on = {"kind": "dc-motor", "stall_torque": stall, "no_load_speed": idle}
    drag = {"drag": {"kind": "joint-effort", "joint": "P0", "effort": {"kind": "formula", "formula": "-0.05 * omega"}}}
    scene = bars(1, 1e-9, duration=spun, sub_intervals=8).changed({"gravity": (0, 0), "joint_laws": drag})
    scene = scene.changed({"analysis.error_estimates": False})
    turning = fm.analyse(scene.changed({"freedoms": {"P0": {"effort": on}}}))
    steady, lag = stall / (stall / idle + brake), inertia / (stall / idle + brake)
    reached = steady * (1 - np.exp(-spun / lag))
    assert float(turning.data["freedom_rate"][-1, 0]) == pytest.approx(reached, rel=1e-7)
    turning.save(tmp_path / "spun.nc")
    coasting = scene.changed({"freedoms": {"P0": {}}, "analysis.start": str(tmp_path / "spun.nc")})
    data = fm.analyse(coasting).data
    after = data["time"].to_numpy() - spun
    np.testing.assert_allclose(data["freedom_rate"][:, 0], reached * np.exp(-brake / inertia * after), rtol=1e-7)


@pytest.mark.slow  # steps of a bending link
def test_a_motion_of_bending_links_goes_on_from_its_end(tmp_path):
    changes = {"materials.stiff.modulus": 2e9, "effects": ("coupling", "gravity", "large-rotations")}
    scene = bent.bars(1, time_tolerance=1e-7, error_estimates=False, duration=0.2).changed(changes)
    whole, goes_on = halves(scene, tmp_path / "half.nc", 5)
    for name, size in {"freedom_place": 1.0, "strain": float(abs(whole["strain"]).max())}.items():
        np.testing.assert_allclose(goes_on[name], whole[name], rtol=0, atol=1e-5 * size)
    start = {"analysis.start": str(tmp_path / "half.nc"), "analysis.start_time": "0.04 s"}
    with pytest.raises(fm.SceneError, match="holds the state of bending links at its end only"):
        fm.analyse(scene.changed(start))
    finer = {"analysis.start": str(tmp_path / "half.nc"), "mesh.elements": 2}
    with pytest.raises(fm.SceneError, match="coordinates, and the scene has"):
        fm.analyse(scene.changed(finer))


def test_what_cannot_be_gone_on_from_is_one_clear_error(tmp_path):
    scene = bars(1, 1e-5, duration=0.2, sub_intervals=4)
    with pytest.raises(fm.SceneError, match=r"there is no file 'nothing\.nc'"):
        fm.analyse(scene.changed({"analysis.start": "nothing.nc"}))
    (tmp_path / "text.nc").write_text("no result")
    with pytest.raises(fm.SceneError, match="is not a result of this program"):
        fm.analyse(scene.changed({"analysis.start": str(tmp_path / "text.nc")}))
    fm.analyse(scene).save(tmp_path / "one.nc")
    start = {"analysis.start": str(tmp_path / "one.nc")}
    with pytest.raises(fm.SceneError, match="has the freedoms P0, and the scene the freedoms P1, P0"):
        fm.analyse(bars(2, 1e-5, duration=0.2).changed({**start, "freedoms": {"P1": {}}}))
    with pytest.raises(fm.SceneError, match=r"no position at 0\.07 s; next to that is 0\.05 s"):
        fm.analyse(scene.changed({**start, "analysis.start_time": 0.07}))


def test_a_motion_without_freedoms_does_not_go_on():
    led = slider_crank(drive={"joint": "O", "speed": 60.0}).changed({"analysis.method": "transient"})
    with pytest.raises(fm.SceneError, match="goes on from no result"):
        fm.analyse(led.changed({"analysis.start": "one.nc"}))


def test_a_motion_does_not_go_on_while_bodies_touch(tmp_path):
    stop = {"kind": "stop", "lower": -0.01, "contact": {"stiffness": 1e3, "exponent": 1.0}}
    scene = bar(stop).changed({"analysis.duration": 0.1, "analysis.sub_intervals": 20})
    scene = scene.changed({"freedoms": {"O": {"start": 0.0}}})
    touches = fm.analyse(scene)
    depth = touches.data["indentation"].to_numpy()[:, 0]
    time = touches.data["time"].to_numpy()
    touches.save(tmp_path / "stop.nc")
    start = {"analysis.start": str(tmp_path / "stop.nc")}
    with pytest.raises(fm.SceneError, match="the bodies of joint 'O' touch"):
        fm.analyse(scene.changed({**start, "analysis.start_time": time[np.argmax(depth > 0)]}))


@pytest.mark.slow  # two cycles in time
def test_a_smooth_start_of_a_led_arm_leaves_it_on_its_periodic_motion():
    swing = {"joint": "P0", "period": 0.5, "law": {"kind": "harmonics", "sine": (0.2,)}}
    scene = bent.bars(1).changed(
        {
            "drive": swing,
            "materials.stiff.modulus": 2e11,
            "effects": ("coupling",),
            "mesh.elements": 2,
            "analysis": {"sub_intervals": 90, "cycles": 1, "settled": 0.0, "error_estimates": False},
        }
    )
    repeats = fm.analyse(scene.changed({"analysis.method": "periodic"})).data["strain"].to_numpy()
    off = {}
    for start in ("rigid", "smooth"):
        in_time = {"analysis.method": "transient", "analysis.start": start, "analysis.time_tolerance": 1e-6}
        strain = fm.analyse(scene.changed(in_time)).data["strain"].to_numpy()[: len(repeats)]
        off[start] = np.abs(strain - repeats).max() / np.abs(repeats).max()
    assert off["smooth"] < 0.02
    assert off["smooth"] < 0.1 * off["rigid"]
