"""The example package in `demos/plugin`, installed into a folder of its own, and packages that are wrong."""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from tests.common import DEMOS, ROOT

SCENE = DEMOS / "plugin" / "bar_on_turntable.toml"
SECTION = "from fenics_mech.scene.sections.plain import RectangleSection as EllipseSection\n"
TABLE = '[plugins.turntable]\nspeed = "30 rad/s"\n'
WIND = """[loads.wind]
kind = "wind"
member = "bar"
wind = [1, 0]
breadth = 1
"""
BRAKE = """[joint_laws.brake]
kind = "eddy-brake"
joint = "O"
critical = 1
"""
INSTALL = "-q", "--no-build-isolation", "--no-deps", "--no-index", "--disable-pip-version-check"


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder that the example is installed in."""
    folder = tmp_path_factory.mktemp("plugin")
    shutil.copytree(DEMOS / "plugin", folder / "source")
    pip = [sys.executable, "-m", "pip", "install", *INSTALL, "--target", folder / "site", folder / "source"]
    subprocess.run(pip, check=True, capture_output=True, timeout=300)
    return folder / "site"


@pytest.fixture
def changed(installed, tmp_path):
    """A copy of the installed example, in which a module has another text."""

    def copy(module, text, old=None):
        shutil.copytree(installed, tmp_path / "site")
        file = tmp_path / "site" / "fenics_mech_turntable" / module
        file.write_text(file.read_text().replace(old, text, 1) if old else text)
        return tmp_path / "site"

    return copy


def command(*arguments, site=None, cwd=ROOT):
    """What the command says with the packages of a folder installed."""
    where = os.pathsep.join(map(str, filter(None, [site, ROOT])))
    code = "from fenics_mech.__main__ import main; main()"
    return subprocess.run(
        [sys.executable, "-P", "-c", code, *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": where},
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def scene(tmp_path, old, new):
    text = SCENE.read_text()
    assert old in text
    (tmp_path / "scene.toml").write_text(text.replace(old, new))
    return tmp_path / "scene.toml"


def test_effect_and_section_of_a_package_act(installed, tmp_path):
    from fenics_mech import Result

    done = command("run", SCENE, "-o", tmp_path, site=installed)
    assert done.returncode == 0, done.stderr
    code = f"from fenics_mech import Result; print(Result.load({str(tmp_path / 'result.nc')!r}).scene.plugins)"
    told = subprocess.run(
        [sys.executable, "-P", "-c", code],
        env=os.environ | {"PYTHONPATH": f"{installed}{os.pathsep}{ROOT}"},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert "speed=30.0" in told.stdout  # the scene goes through the file
    data = Result.load(tmp_path / "result.nc").data
    radius, modulus, density, area = 0.5 * data["s"].to_numpy(), 210e9, 7850, np.pi * 8e-3 * 4e-3 / 4
    slow = 30 * np.sqrt(density / modulus)  # (E u')' + rho speed^2 (x + u) = 0: the stretched bar is further out
    force = modulus * area * (np.cos(slow * radius) / np.cos(slow * 0.5) - 1)
    found = data["axial_force"].squeeze().to_numpy()
    assert found[0] == pytest.approx(force[0], rel=1e-7)  # 3e-6 is by the stretch
    assert np.allclose(found, force, rtol=0, atol=2e-6 * force[0])  # linear theory has loads inside elements at rest


SWING = """
name = "bar that swings on a turntable"
ground.points = { O = [0, 0], P = ["200 mm", 0] }
[links.bar]
points = { P = [0, 0], A = ["300 mm", 0] }
rigid = { mass = "2 kg", inertia = "0.01 kg m^2", centre = ["100 mm", 0] }
[joints]
P.connect = ["ground.P", "bar.P"]
[freedoms.P]
start = "50 deg"
[plugins.turntable]
speed = "30 rad/s"
[analysis]
method = "static"
"""


def test_effect_of_a_package_acts_on_rigid_links(installed, tmp_path):
    """A bar rests along the radius, and swings about that by ``w^2 a m s/(J + m s^2)``."""
    from fenics_mech import Result

    (tmp_path / "scene.toml").write_text(SWING)
    done = command("run", tmp_path / "scene.toml", "-o", tmp_path, site=installed)
    assert done.returncode == 0, done.stderr
    data = Result.load(tmp_path / "result.nc").data
    assert float(data["freedom_place"][0, 0]) == pytest.approx(0, abs=1e-9)
    square = 30**2 * 0.2 * 2 * 0.1 / (0.01 + 2 * 0.1**2)
    assert float(data["rest_frequency"][0]) == pytest.approx(np.sqrt(square) / (2 * np.pi), rel=1e-8)


def test_load_and_plot_of_a_package(installed, tmp_path):
    """Strain at the root of a strip, by the closed form, and the plot of its axial force."""
    from fenics_mech import Result

    done = command("run", DEMOS / "plugin" / "strip_in_wind.toml", "-o", tmp_path, site=installed)
    assert done.returncode == 0, done.stderr
    drawn = command("plot", tmp_path / "result.nc", "-o", tmp_path, "--only", "axial_force", site=installed)
    assert (tmp_path / "axial_force.png").stat().st_size > 5000, drawn.stderr
    line, length, breadth, height = 2.0 * 1.2 * 20e-3 * 10**2 / 2, 0.3, 20e-3, 2e-3
    strain = line * length**2 / 2 / (210e9 * breadth * height**3 / 12) * height / 2
    data = Result.load(tmp_path / "result.nc").data
    assert np.abs(data["strain"].sel(s=0)).max() == pytest.approx(strain, rel=2e-3)


def test_joint_law_of_a_package(installed, tmp_path):
    """A disc runs down in an eddy-current brake as by the closed form."""
    from fenics_mech import Result

    done = command("run", DEMOS / "plugin" / "braked_disc.toml", "-o", tmp_path, site=installed)
    assert done.returncode == 0, done.stderr
    data = Result.load(tmp_path / "result.nc").data
    rate, time = data["freedom_rate"].squeeze().to_numpy(), data["time"].to_numpy()
    assert rate[-1] < 50  # it has passed the critical speed
    left = np.log(rate / 300) + (rate**2 - 300**2) / (2 * 100**2)
    assert np.allclose(left, -2 * 5 * time / (0.02 * 100), atol=1e-6)


def test_keys_of_a_package_stand_in_the_schema(installed):
    schema = json.loads(command("schema", site=installed).stdout)
    table = schema["properties"]["plugins"]["properties"]["turntable"]
    assert table["required"] == ["speed"]
    assert "turntable (rad/s)" in table["properties"]["speed"]["description"]
    assert "Size in the plane" in schema["$defs"]["EllipseSection"]["properties"]["height"]["description"]
    assert "Coefficient of drag" in schema["$defs"]["WindLoad"]["properties"]["drag"]["description"]
    brake = schema["$defs"]["EddyBrake"]
    assert set(brake["required"]) == {"kind", "joint", "torque", "critical"}
    assert "Critical speed (rad/s)" in brake["properties"]["critical"]["description"]
    assert "turntable" not in command("schema").stdout


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('speed = "30 rad/s"', 'speed = "30 kg"', r"plugins.turntable.speed \(line 27\): .*kg"),
        ('speed = "30 rad/s"', "pace = 1", "plugins.turntable.speed .*: this key is missing"),
        ('height = "4 mm"', 'height = "-4 mm"', r"sections.bar.height \(line 10\): .*greater than 0"),
        ('shape = "ellipse"', 'shape = "egg"', "no such shape of section; known are .*taper, ellipse"),
        (TABLE, f"{WIND}pace = 1\n", r"loads.wind.pace \(line \d+\): .*nknown key"),
        (TABLE, f"{WIND}line = [1, 0]\n", "loads.wind .*`line` follows from the other keys"),
        (TABLE, f"{BRAKE}torque = -1\n", r"joint_laws.brake.torque \(line \d+\): .*greater than 0"),
        ("[plugins.turntable]", "[plugins.merry]", "plugins.merry .*no plugin 'merry'. Those that .* here: turntable"),
    ],
)
def test_mistakes_in_keys_of_a_package_are_told_with_their_place(installed, tmp_path, old, new, said):
    done = command("check", scene(tmp_path, old, new), site=installed)
    assert done.returncode == 1
    assert re_search(said, done.stderr), done.stderr


def re_search(pattern, text):
    """Search in a text without its line breaks."""
    return re.search(pattern, " ".join(text.split()))


@pytest.mark.parametrize(
    ("module", "text", "old", "said"),
    [
        ("turntable.py", "import nowhere\n", None, "'turntable' of the package fenics.mech.turntable cannot be loaded"),
        ("turntable.py", "EFFECT = 3\n", None, "gives int where Effect is expected"),
        ("turntable.py", "speed ** [][0]", "speed ** 2", "'turntable' of .* failed in acting: IndexError"),
        ("turntable.py", "place[7] + place, by", "place, by", "'turntable' of .* failed in respond: IndexError"),
        ("turntable.py", 'found["members"] = 3  # ', 'found["members"] = ', "must give terms of `fenics_mech.terms`"),
        ("turntable.py", "", "    acting=acting,\n", "must state by `acting` the terms of poses that it adds"),
        ("turntable.py", '"gravity",\n    meaning', '"turntable",\n    meaning', "must have that name in its record"),
        ("ellipse.py", SECTION, None, "'ellipse' of .* needs a field `shape: Literal"),
        ("ellipse.py", "self.height / {}", "self.height / 2", "'ellipse' of .* failed in rigidity: TypeError"),
    ],
)
def test_a_package_that_is_wrong_is_named(changed, tmp_path, module, text, old, said):
    done = command("run", SCENE, "-o", tmp_path, site=changed(module, text, old))
    assert done.returncode == 1
    assert re_search(said, done.stderr), done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("module", "text", "old", "scene", "said"),
    [
        (
            "wind.py",
            '"gale"] = "gale"',
            '"wind"] = "wind"',
            "strip_in_wind",
            "'wind' of .* needs a field `kind: Literal",
        ),
        ("wind.py", "self.air / 0", "self.air", "strip_in_wind", "'wind' of .* failed in computed: ZeroDivisionError"),
        (
            "brake.py",
            "rate / []",
            "rate / self.critical",
            "braked_disc",
            "'eddy-brake' of .* failed in effort_at",
        ),
        (
            "brake.py",
            "AtJoint as Plug",
            "Plug",
            "braked_disc",
            "'eddy-brake' of .* where a class derived from",
        ),
        (
            "along_members.py",
            "result.dat.x",
            "result.data",
            "strip_in_wind",
            "'axial_force' .* failed in axial_force",
        ),
        ("along_members.py", "return 3", "return None", "braked_disc", "'axial_force' .* gives int where a Figure"),
    ],
)
def test_a_load_joint_law_or_plot_that_is_wrong_is_named(changed, tmp_path, module, text, old, scene, said):
    done = command(
        "run", DEMOS / "plugin" / f"{scene}.toml", "-o", tmp_path, "--plots", site=changed(module, text, old)
    )
    assert done.returncode == 1
    assert re_search(said, done.stderr), done.stderr
    assert "Traceback" not in done.stderr


def test_a_scene_in_the_folder_of_a_package_cannot_load_it(installed, tmp_path):
    """Even by `python -m`, which puts the current folder first."""
    folder = tmp_path / "from_a_stranger"
    shutil.copytree(installed, folder)
    shutil.copy(SCENE, folder)
    done = subprocess.run(
        [sys.executable, "-c", "from fenics_mech.__main__ import main; main()", "check", SCENE.name],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 1
    assert "there is no plugin 'turntable'" in done.stderr
