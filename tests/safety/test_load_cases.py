"""Load cases: the envelope is the largest of separate runs, the governing case is named, errors name their case."""

import json
import math

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import ResultError, SceneError
from fenics_mech.planning.fine_enough import free_numbers
from fenics_mech.recovery.stress_figures import life_used
from fenics_mech.safety import judge
from fenics_mech.safety.load_cases import envelope
from fenics_mech.studies.case_runs import analyse_cases
from fenics_mech.studies.design.result_numbers import Curve, Quantity
from fenics_mech.views.case_tables import governed
from fenics_mech.views.key_figures import key_figures
from fenics_mech.views.page.report import page
from fenics_mech.views.workbook import sheets_of
from tests.common import DEMOS

from .machines import E, along, middle, rectangle, rod

WIDE, HIGH, LONG = 0.03, 0.02, 1.0
STEEL = {"yield": 300e6, "ultimate": 400e6}
PUSH, SIDE = 20e3, 400.0  # N
CASES = [
    {"name": "push", "off": ["F1"]},
    {"name": "bend", "set": {"loads": {"F0": {"force": [0.0, 0.0]}}}},
    {"name": "both_half", "set": {"loads.F0.force": [-PUSH / 2, 0.0], "loads.F1.force": [0.0, SIDE / 2]}},
]


@pytest.fixture(scope="module")
def scene():
    made = rod(rectangle(WIDE, HIGH), [along(-PUSH), middle(SIDE)], LONG, STEEL)
    return made.changed(cases=CASES)


@pytest.fixture(scope="module")
def result(scene):
    return fm.analyse(scene)


def test_the_envelope_is_the_largest_of_separate_runs_to_the_last_bit(scene, result):
    alone = {case["name"]: fm.analyse(fm.in_case(scene, case["name"])) for case in CASES}
    for name, one in alone.items():
        for variable in ("stress", "deflection", "joint_force", "input_torque"):
            assert np.array_equal(one.data[variable], result.cases[name].data[variable]), (name, variable)
    most = envelope(result)
    stress = {name: float(abs(one.data["stress"]).max()) for name, one in alone.items()}
    assert float(most["case_stress"].sel(member="rod")) == max(stress.values())
    assert str(most["case_stress_in"].sel(member="rod").item()) == max(stress, key=stress.__getitem__)
    for joint in ("O", "A", "B", "G"):
        force = {
            name: float(np.linalg.norm(one.data["joint_force"].sel(joint=joint), axis=-1).max())
            for name, one in alone.items()
        }
        assert float(most["case_joint_force"].sel(joint=joint)) == max(force.values())
    bent = {name: float(np.linalg.norm(one.data["deflection"], axis=-1).max()) for name, one in alone.items()}
    assert float(most["case_deflection"].sel(member="rod")) == max(bent.values())
    torque = {name: float(abs(one.data["drive_effort"]).max()) for name, one in alone.items()}
    assert float(most["case_effort"].sel(drive="O")) == max(torque.values())
    shares = {name: judge(one).governing[1].share for name, one in alone.items()}
    assert float(most["case_safety"].sel(member="rod")) == min(shares.values())
    assert result.case == min(shares, key=shares.__getitem__)


def test_mesh_and_steps_that_nobody_states_stay_the_programs_in_a_case():
    """A case is the scene changed by hand, and gets as fine a mesh as it needs."""
    scene = fm.load(DEMOS / "four_bar.toml").changed({"analysis": {"modes": 3}, "mesh": {}})
    cased = scene.changed(cases=[{"name": "slow", "set": {"drive.speed": "100 rpm", "analysis.sub_intervals": 90}}])
    by_hand = scene.changed({"drive.speed": "100 rpm", "analysis.sub_intervals": 90})
    assert free_numbers(fm.in_case(cased, "slow")) == free_numbers(by_hand)
    assert "elements" in free_numbers(by_hand)
    assert fm.in_case(cased, "slow").stated_data()["analysis"] == by_hand.stated_data()["analysis"]


def test_names_of_cases_are_told_as_they_are(scene, result):
    with pytest.raises(SceneError, match=r"cases\.0\.name: must be a name of .* a letter or _ first"):
        scene.changed(cases=[{"name": "3000rpm"}])
    assert governed(result).endswith("3 load cases; push governs")
    assert governed(fm.Result(result.data, {"push": result.cases["push"]})).endswith(": one load case")


@pytest.mark.parametrize("names", [["../../push", "bend", "both_half"], ["push", "bend"], ["<b>", "bend"], "push", []])
def test_files_that_tell_of_other_cases_are_refused(result, names, tmp_path):
    """Their names become names of pages: a stranger's file must not choose them."""
    told = json.loads(result.data.attrs["cases"]) | {"names": names}
    strange = fm.Result(result.data.assign_attrs(cases=json.dumps(told)), result.cases)
    with pytest.raises(ResultError, match=r"it (does not tell its load cases|tells of other load cases than it holds)"):
        fm.Result.load(strange.save(tmp_path / "result.nc"))


def test_the_least_factor_and_its_case_are_those_by_hand(result):
    # Euler: pi^2 E I/L^2 of 20 mm x 30 mm in the plane is 41.5 kN, 2.07 of the push; across it is 2.25 times as much.
    inertia = WIDE * HIGH**3 / 12
    checks = {check.mode: check for check in judge(result).checks["rod"]}
    assert checks["buckling in plane"].factor == pytest.approx(math.pi**2 * E * inertia / LONG**2 / PUSH, rel=1e-3)
    assert checks["buckling in plane"].case == "push"
    bending = SIDE * LONG / 4 * (HIGH / 2) / inertia  # Pa: a beam on two pins with a force at its middle
    assert checks["yield"].acting == pytest.approx(bending, rel=1e-6)
    assert checks["yield"].case == "bend"
    assert judge(result).governing == ("rod", checks["buckling in plane"])


def test_the_cure_does_in_every_case(scene, result):
    cure = judge(result).cure
    assert cure.place == "sections.s.height"
    least, enough = (
        judge(fm.analyse(scene.changed({cure.place: size * cure.needed}))).governing[1].share for size in (0.97, 1)
    )
    assert enough >= 1 > least


def test_every_output_names_the_governing_case(result):
    said = str(fm.summary(result))
    assert "3 load cases; push governs" in said.splitlines()[0]
    assert "case push" in " ".join(said.splitlines()[1:4])
    assert len(said.splitlines()) <= 31  # and a line that tells the files
    figures = json.loads(json.dumps(key_figures(result)))
    assert (figures["case"], figures["safety"]["case"]) == ("push", "push")
    assert figures["envelope"]["stress"]["rod"]["case"] == "bend"
    assert set(figures["cases"]) == {"push", "bend", "both_half"}
    text = page(result, {"bend": "report_bend.html"})
    assert 'href="report_bend.html"' in text
    assert "case push" in text
    sheets = {sheet.name: [list(row) for row in sheet.rows] for sheet in sheets_of(result)}
    assert ["largest stress", "rod", pytest.approx(50.0, rel=1e-6), "MPa", "bend"] in sheets["envelope"]
    assert sheets["load cases"][0][0] == "push"


@pytest.mark.long
@pytest.mark.slow
def test_the_summary_of_many_cases_and_members_fits_a_screen():
    still = {"analysis.method": "quasi-static", "analysis.sub_intervals": 72, "effects": ()}
    cases = [{"name": f"speed_{n}", "set": {"drive": {"speed": f"{n} rpm"}}} for n in (60, 75, 90, 105, 120, 135)]
    said = str(fm.summary(fm.analyse(fm.load(DEMOS / "jansen.toml").changed({**still, "cases": cases})))).splitlines()
    assert len(said) <= 31
    assert "and 3 safer ones: see the report" in [line.strip() for line in said]


def test_a_file_gives_back_all_cases(result, tmp_path):
    back = fm.Result.load(result.save(tmp_path / "result.nc"))
    assert back.data.equals(result.data)
    assert {name: one.data.equals(result.cases[name].data) for name, one in back.cases.items()} == dict.fromkeys(
        ("push", "bend", "both_half"), True
    )
    assert judge(back) == judge(result)
    assert back.stated == result.stated
    assert back.told_in(["psi"]).cases["bend"].scene.units == ("psi",)


def test_a_scene_without_cases_has_nothing_of_them(scene):
    alone = fm.analyse(scene.changed(cases=()))
    assert (alone.cases, alone.case) == ({}, "")
    assert not [name for name in (*alone.data.variables, *alone.data.attrs) if "case" in str(name)]
    assert alone.stored is alone.data
    assert "case" not in str(fm.summary(alone))


def test_cases_change_speed_gravity_and_friction(tmp_path):
    text = """
[ground]
points = { O = [0, 0], G = [0, 0] }
[links.crank]
points = { O = [0, 0], A = ["60 mm", 0] }
rigid = { mass = "1 kg" }
[links.rod]
points = { A = [0, 0], B = ["300 mm", 0] }
rigid = { mass = "1 kg" }
[joints]
O.connect = ["ground.O", "crank.O"]
A.connect = ["crank.A", "rod.A"]
B = { kind = "slot", connect = ["ground.G", "rod.B"] }
[joint_laws.bearing]
kind = "friction"
joint = "A"
coefficient = 0.1
radius = "10 mm"
[drive]
joint = "O"
speed = "60 rpm"
[analysis]
method = "quasi-static"
sub_intervals = 24
[[cases]]
name = "dry"
[[cases]]
name = "oiled"
set.joint_laws.bearing.coefficient = 0.0
[[cases]]
name = "fast_and_heavy"
set.drive.speed = "120 rpm"
set.gravity = [0, "-9.81 m/s^2"]
"""
    (tmp_path / "machine.toml").write_text(text)
    stated = fm.load(tmp_path / "machine.toml")
    dry, oiled, fast = (fm.in_case(stated, name) for name in ("dry", "oiled", "fast_and_heavy"))
    assert (dry.joint_laws["bearing"].coefficient, oiled.joint_laws["bearing"].coefficient) == (0.1, 0.0)
    assert fast.drive.speed == pytest.approx(4 * math.pi)
    assert fast.gravity == (0.0, -9.81)
    assert dry.name == "machine, case dry"
    found = fm.analyse(stated)
    torque = found.data["case_effort"].sel(drive="O")
    assert torque.sel(case="dry") > torque.sel(case="oiled") * (1 + 1e-4)
    assert found.case == "fast_and_heavy"  # rigid links: that of the largest joint force
    assert "load case" in str(fm.summary(found))
    fm.write_scene(stated, tmp_path / "copy.toml")
    assert fm.load(tmp_path / "copy.toml").cases == stated.cases


LINE = "sections.s.height"
BAD = [
    ([{"name": "a"}, {"name": "a"}], "two load cases have the name 'a'"),
    ([{"name": "a", "off": ["F9"]}], "cases.0.off: there is no load or impulse 'F9'"),
    ([{"name": "a", "set": {"links": {"rod": {"angle": 1}}}}], "cases.0.set.links.rod.angle: a load case does not"),
    ([{"name": "a", "set": {"drive": {"sped": 1}}}], "load case 'a': unknown key 'sped'. Did you mean 'speed'?"),
    ([{"name": "a", "cycles": 3}, {"name": "b"}], "load case 'b' states no `cycles`"),
    ([{"name": "a", "share": 0.4}, {"name": "b", "share": "40 %"}], "the shares of time are 80 % in all"),
    ([{"name": "a", "share": 1, "cycles": 1}], "give either `cycles` or `share`"),
    ([{"name": "a b"}], "must be a name"),
]


@pytest.mark.parametrize(("cases", "said"), BAD)
def test_what_is_wrong_with_a_case_is_said(scene, cases, said):
    with pytest.raises(fm.SceneError) as error:
        scene.changed(cases=cases)
    assert said in str(error.value)


def test_errors_name_the_line_of_their_case(tmp_path):
    text = '[drive]\njoint = "O"\n[[cases]]\nname = "a"\n[[cases]]\nname = "b"\nset.drive.joint = "Q"\n'
    base = fm.load("demos/slider_crank.toml")
    fm.write_scene(base.changed(drive={"joint": "O", "speed": 1.0}), tmp_path / "base.toml")
    stated = (tmp_path / "base.toml").read_text() + text.split("\n", 2)[2]
    (tmp_path / "two.toml").write_text(stated)
    with pytest.raises(fm.SceneError) as error:
        fm.load(tmp_path / "two.toml")
    assert error.value.line == stated.splitlines().index('set.drive.joint = "Q"') + 1
    assert "load case 'b'" in str(error.value)


def test_one_damaged_case_ends_the_run_and_is_named(scene):
    buckled = {"name": "buckled", "set": {"loads": {"F0": {"force": [-60e3, 0]}}, "effects": ["geometric-stiffness"]}}
    with pytest.raises(fm.SolverError, match=r"^load case 'buckled': "):
        fm.analyse(scene.changed(cases=[CASES[0], buckled]))


def test_numbers_of_studies_are_the_worst_of_all_cases_or_of_one(result):
    assert Quantity.read("safety.min").of(result) == judge(result).governing[1].share
    assert Quantity.read("safety[bend].min").of(result) == judge(result.cases["bend"]).governing[1].share
    largest = float(envelope(result)["case_stress"].sel(member="rod"))
    assert Quantity.read("stress[rod].max").of(result) == largest
    assert Quantity.read("stress[push].max").of(result) < largest
    with pytest.raises(fm.SceneError, match="curve of each load case"):
        Curve.at("torque", [0.0]).numbers(result, {})


def test_what_answers_one_case_refuses_several(scene):
    with pytest.raises(fm.SceneError, match=r"a sweep is of one\. Take it in one of push, bend, both_half"):
        fm.sweep(scene, {"drive.speed": [1.0, 2.0]})
    assert fm.sweep(fm.in_case(scene, "push"), {"drive.speed": [0.01]}).paths == ["drive.speed"]


CURVE = {"range": 100e6, "cycles": 2e6, "slope": 4}
ALTERNATING = {"factor": {"kind": "harmonics", "cosine": [1.0]}}


def test_fatigue_adds_the_damage_of_all_cases():
    """Miner: n1/N1 + n2/N2, with N = N0 (S0/S)^m and S = 2 P L/4/W."""
    forces, cycles = {"light": 200.0, "hard": 400.0}, {"light": 1e7, "hard": 1e5}
    cases = [
        {"name": name, "set": {"loads": {"F0": {"force": [0.0, force]}}}, "cycles": cycles[name]}
        for name, force in forces.items()
    ]
    material = STEEL | {"fatigue": CURVE}
    machine = rod(rectangle(WIDE, HIGH), [middle(1.0, **ALTERNATING)], LONG, material, sub_intervals=12)
    stated = machine.changed(cases=cases)
    result = fm.analyse(stated)
    modulus = WIDE * HIGH**2 / 6
    damage = {
        name: cycles[name] / CURVE["cycles"] * (2 * force * LONG / 4 / modulus / CURVE["range"]) ** CURVE["slope"]
        for name, force in forces.items()
    }
    found = life_used(result)
    for name in forces:  # the crank of 1 mm turns the rod by 1e-3, and its inertia adds nothing at 0.01 rad/s
        assert float(found["used"].sel(case=name, member="rod")) == pytest.approx(damage[name], rel=1e-4)
    assert float(found["life_used"].sel(member="rod")) == pytest.approx(sum(damage.values()), rel=1e-4)
    check = next(check for check in judge(result).checks["rod"] if check.mode == "fatigue")
    assert check.factor == pytest.approx(sum(damage.values()) ** (-1 / CURVE["slope"]), rel=1e-4)
    assert check.case == max(damage, key=damage.__getitem__)


def test_shares_of_time_become_cycles_by_the_speed(scene):
    cases = [{"name": "slow", "share": "75 %"}, {"name": "fast", "share": 0.25, "set": {"drive": {"speed": 0.03}}}]
    stated = scene.changed(cases=cases, design={"cycles": 1e6})
    found = fm.analyse(stated).cycles  # 0.75 x 0.01 and 0.25 x 0.03 are the same number of turns
    assert found == {"slow": pytest.approx(5e5), "fast": pytest.approx(5e5)}


@pytest.mark.slow
def test_processes_give_the_same(scene, result):
    shared = analyse_cases(scene, 2)
    assert shared.data.equals(result.data)
    assert all(one.data.equals(result.cases[name].data) for name, one in shared.cases.items())
